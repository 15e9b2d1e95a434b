#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "localization/compass/colour/colour_model.hpp"

namespace ceilmap::colour {

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

/// What WriteColourModel writes: some 1 MB for 15 full cells of 180 bins and 8 classes.
std::string FormatColourModel(const ColourModel& model);

/// Writes the file complete or not at all.
/// @param model  valid. @throws RunError when it is larger than could be read again, or the
///   disk refuses; InputError when there can be no such file.
void WriteColourModel(const ColourModel& model, const std::filesystem::path& file);

/// Reads a model that has at least one bin with something in it.
/// @throws InputError, one line with the file, what is wrong and how to mend it: no such
///   file, too large, empty, no JSON, another format, a newer version, sizes that do not fit each
///   other, numbers that cannot be, or nothing learned.
ColourModel ReadColourModel(const std::filesystem::path& file);

/// Maximum number of frequencies of a model, 4 bytes each, because a few bytes of text may
/// represent many.
inline constexpr std::int64_t kMaxColourModelFrequencies = 128'000'000;

/// The same from a file's text. @param file  its name in messages. @param max_frequencies  for
///   tests.
ColourModel ParseColourModel(const std::string& text,
                             const std::filesystem::path& file,
                             std::int64_t max_frequencies = kMaxColourModelFrequencies);

}  // namespace ceilmap::colour
