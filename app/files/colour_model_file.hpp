#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "localization/compass/colour/colour_model.hpp"

namespace ceilmap::files {

/// The file of a colour model: one JSON document, identical on all machines.
///
///     {"format": "ceilmap colour model", "version": 1, "program": "...", "kind": "victoria",
///      "bins": 180, "grid": {...}, "depth_m": 3.5, "fading_s": 600, "frames": 91,
///      "provenance": "...", "classes": [{"mean": [Y, U, V], "covariance": [9], "weight": 0.1},
///      ...], "cells": [[{"bin": 3, "certainty": 4.5, "stamp_s": 12.5, "place_m": [1.2, 0.4],
///                  "transitions": [71234, -7, 1203, ...]}, ...], ...]}
///
/// Cells are stored by rows, each with its non-empty bins. `transitions` are the k x k frequencies
/// in units of 1e-5; -n stands for n zeros. `variance`, only for kSturm, in units of 1e-8.

/// Larger files are refused before they are read.
inline constexpr std::uintmax_t kMaxColourModelBytes = 64U << 20U;

/// Text of a model: about 1 MB for 15 full cells of 180 bins and 8 classes.
std::string FormatColourModel(const colour::ColourModel& model);

/// Writes the file completely or not at all.
/// @param model  Valid. @throws RunError when it is larger than the maximum for reading, or the
/// disk cannot be written; InputError when the file cannot be created.
void WriteColourModel(const colour::ColourModel& model, const std::filesystem::path& file);

/// Reads a model that has at least one non-empty bin.
/// @throws InputError, one line with the file, the problem and its solution: no such file, too
/// large, empty, not JSON, another format, a newer version, inconsistent sizes, invalid numbers, or
/// an empty model.
colour::ColourModel ReadColourModel(const std::filesystem::path& file);

/// Maximum number of frequencies of a model, 4 bytes each, because a few bytes of text may
/// represent many.
inline constexpr std::int64_t kMaxColourModelFrequencies = 128'000'000;

/// The same from the text of a file. @param file  Its name in messages. @param max_frequencies  For
/// tests.
colour::ColourModel ParseColourModel(const std::string& text,
                                     const std::filesystem::path& file,
                                     std::int64_t max_frequencies = kMaxColourModelFrequencies);

}  // namespace ceilmap::files
