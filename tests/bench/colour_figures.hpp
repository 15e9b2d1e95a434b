#pragma once

#include <filesystem>
#include <vector>

namespace ceilmap::bench {

/// Figure 3 of Methenitis et al. 2013 (ViCTORiA): of the scan line of a recording with the most
/// different transitions, its image in the colours of the classes, with the line between two white
/// ones, and its transitions. Prints CSV: `class,N,,COLOUR` with 0xRRGGBB as a decimal number, and
/// `transition,FROM,TO,FREQUENCY`.
/// @param model  of `compass learn`. @param folder  a recording. @param picture  a PNG file.
void PrintTransitions(const std::filesystem::path& model,
                      const std::filesystem::path& folder,
                      const std::filesystem::path& picture);

/// Figure 6: frequencies of the values of Y, U and V, summed over the images of each recording, as
/// the camera has them and after the white balance to a model. Prints CSV:
/// `folder,channel,value,frequency,balanced`, where a value stands for four.
void PrintHistograms(const std::filesystem::path& model,
                     const std::vector<std::filesystem::path>& folders);

}  // namespace ceilmap::bench
