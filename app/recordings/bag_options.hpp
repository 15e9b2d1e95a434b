#pragma once

#include <CLI/CLI.hpp>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "app/recordings/bag_source.hpp"

namespace ceilmap::recordings {

/// Options of a command whose sources may be bags: the topic of each, and the times.
class BagOptions {
 public:
  /// Adds --stamp, and --NAME-topic for each source.
  /// @param sources  names of the options without dashes; the first one is the main source, whose
  /// bag the others may share.
  void AddTo(CLI::App& cli, const std::vector<std::string>& sources);

  /// A source as it is given, or the bag of the main source where only the topic is given.
  /// @param main  option and value of the main source. @throws InputError where a topic is given of
  /// what is no bag.
  [[nodiscard]] std::string Complete(const std::string& source,
                                     const std::string& given,
                                     const std::string& main_option,
                                     const std::string& main) const;
  /// @throws InputError where a topic of the main source is given, which is no bag.
  void CheckMain(const std::string& source, const std::string& given) const;
  [[nodiscard]] BagTopic Topic(const std::string& source) const;
  /// The same, to be read by a pass of its own over the bag.
  [[nodiscard]] BagTopic TopicAlone(const std::string& source) const;
  /// The bags of this run.
  [[nodiscard]] OpenBags& Bags() const { return *bags_; }

 private:
  std::map<std::string, std::string> topics_;  // by the source
  std::string stamp_ = "header";
  std::shared_ptr<OpenBags> bags_ = std::make_shared<OpenBags>();
};

}  // namespace ceilmap::recordings
