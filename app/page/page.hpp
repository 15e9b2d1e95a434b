#pragma once

#include <cstdint>
#include <string>

#include "app/page/page_data.hpp"

namespace ceilmap::page {

/// The page as one HTML file that needs nothing else: no network, no other file. Every name and
/// text of `data` is shown as it is, whatever characters it has.
///
/// Long paths are kept whole as far as 200,000 poses on the page; of longer ones, evenly chosen
/// poses stand for the rest; of a curve of a chart of more than 20,000 points, the first, least and
/// greatest of equal stretches. 100,000 poses take about 0.1 s and 5 MB.
/// @throws std::invalid_argument as PageData::Validate.
std::string WritePage(const PageData& data);

/// The page for a run that goes on, to be served: it takes its data from `document_url` (what
/// WriteDocument writes) twice a second and shows what is new, without losing the view that the
/// user has chosen. It says so when nobody answers any more, and when the run has ended.
/// @param document_url  relative, e.g. "document.json".
std::string WriteServedPage(const std::string& title, const std::string& document_url);

/// How far a run has come, for a page that is served.
struct RunState {
  std::int64_t revision = 0;  ///< rises with everything new
  bool running = false;
  double rate_hz = 0;                ///< frames per second of late; 0: not known
  std::int64_t frames = 0;           ///< done
  std::int64_t frames_expected = 0;  ///< 0: not known
};

/// The data of a page as JSON.
/// @param state  comes with it, for a page that is served.
/// @param picture_url  where the picture is to be had, for a page that is served; empty: it is in
///   the document, as a data URL.
std::string WriteDocument(const PageData& data,
                          const RunState& state = {},
                          const std::string& picture_url = {});

/// What a served page takes instead of a document when there is nothing new but the state itself:
/// it asks for `document_url?revision=N` with the revision N that it shows.
std::string WriteUnchanged(const RunState& state);

}  // namespace ceilmap::page
