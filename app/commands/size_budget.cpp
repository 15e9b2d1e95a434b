#include "app/commands/size_budget.hpp"

#include <cmath>

namespace ceilmap::commands {

std::optional<std::uint64_t> SizeBudget::Bytes() const {
  if (megabytes == 0) return std::nullopt;
  return static_cast<std::uint64_t>(std::llround(1e6 * megabytes));
}

void SizeBudget::AddTo(CLI::App& cli, const std::string& text, const std::string& group) {
  cli.add_option("--size-budget", megabytes, text)
      ->type_name("MB")
      ->check(CLI::Range(0.001, 1e9))
      ->group(group);
}

}  // namespace ceilmap::commands
