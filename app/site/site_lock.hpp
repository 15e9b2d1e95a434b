#pragma once

#include <filesystem>

namespace ceilmap::site {

/// Lets one run at a time work on a site, by locks on two files of its work folder: one that ends
/// with the run, and one that its jobs inherit. After a run was killed, the next one waits until
/// its jobs are gone too, which die with it.
class SiteLock {
 public:
  /// @param work  the folder, which exists. Without locks of the file system (some network folders)
  ///   the user must prevent two runs.
  /// @throws InputError when another run works on the site, or the folder is not writable.
  explicit SiteLock(const std::filesystem::path& work);
  ~SiteLock();
  SiteLock(const SiteLock&) = delete;
  SiteLock& operator=(const SiteLock&) = delete;

  /// To be inherited by the jobs.
  [[nodiscard]] int JobsDescriptor() const { return jobs_; }

 private:
  int run_ = -1;
  int jobs_ = -1;
};

}  // namespace ceilmap::site
