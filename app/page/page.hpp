#pragma once

#include <cstdint>
#include <string>

#include "app/page/page_data.hpp"

namespace ceilmap::page {

/// The page as one self-contained HTML file. All texts of `data` are escaped.
///
/// All poses are kept up to 200,000 on the page; above that, evenly spaced poses are kept. Of a
/// curve of more than 20,000 points, the first, smallest and largest point of equal intervals are
/// kept. 100,000 poses take about 0.1 s and 5 MB.
/// @throws std::invalid_argument as PageData::Validate.
std::string WritePage(const PageData& data);

/// The page of a running command, to be served. It loads its data from `document_url` (the output
/// of WriteDocument) twice a second and shows changes without changing the user's view. It shows
/// when the server does not answer, and when the run has ended.
/// @param document_url  Relative, e.g. "document.json".
std::string WriteServedPage(const std::string& title, const std::string& document_url);

/// Progress of a run, for a served page.
struct RunState {
  std::int64_t revision = 0;  ///< increases with every change
  bool running = false;
  double rate_hz = 0;                ///< recent frames per second; 0: unknown
  std::int64_t frames = 0;           ///< done
  std::int64_t frames_expected = 0;  ///< 0: unknown
};

/// The data of a page as JSON.
/// @param state  Included for a served page.
/// @param picture_url  URL of the picture, for a served page; empty: the document contains it as a
/// data URL.
std::string WriteDocument(const PageData& data,
                          const RunState& state = {},
                          const std::string& picture_url = {});

/// Answer to a served page instead of a document when only the state has changed. The page requests
/// `document_url?revision=N` with the revision N that it shows.
std::string WriteUnchanged(const RunState& state);

}  // namespace ceilmap::page
