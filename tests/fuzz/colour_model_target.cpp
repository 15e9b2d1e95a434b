#include <string>

#include "localization/compass/colour/colour_model_file.hpp"
#include "tests/fuzz/promise.hpp"
#include "tests/fuzz/targets.hpp"

namespace ceilmap::fuzz {

void ReadAsColourModel(std::string_view bytes) {
  const std::string text(bytes);
  constexpr std::int64_t kMaxFrequencies = 1'000'000;
  const auto model =
      Accepted([&] { return colour::ParseColourModel(text, "model", kMaxFrequencies); });
  if (!model) return;
  model->Validate();
  // What was written and read is not changed by being written again.
  const std::string once = colour::FormatColourModel(*model);
  const auto read = Accepted([&] { return colour::ParseColourModel(once, "once"); });
  if (!read) return;  // small numbers round to 0, which a depth or a certainty must not be
  const std::string twice = colour::FormatColourModel(*read);
  Require(colour::FormatColourModel(colour::ParseColourModel(twice, "twice")) == twice,
          "a model reads back as another one");
}

}  // namespace ceilmap::fuzz
