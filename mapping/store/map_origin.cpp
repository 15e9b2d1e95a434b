#include "mapping/store/map_origin.hpp"

#include <array>

#include "calib/base/error.hpp"
#include "calib/base/remote_name.hpp"
#include "mapping/store/map_schema.hpp"

namespace ceilmap::store {
namespace {

/// Runs `action` and adds the map's name to its errors.
template <typename Action>
auto WithName(const std::filesystem::path& path, const Action& action) {
  const auto named = [&path](const std::exception& error) {
    return WithoutSecrets(path.string()) + ": " + error.what();
  };
  try {
    return action();
  } catch (const InputError& error) {
    throw InputError(named(error));
  } catch (const RunError& error) {
    throw RunError(named(error));
  }
}

std::unique_ptr<RemoteDatabase> Connect(const std::filesystem::path& path) {
  if (!IsRemoteName(path.string())) return nullptr;
  return WithName(path, [&] { return std::make_unique<RemoteDatabase>(path.string()); });
}

}  // namespace

MapOrigin::MapOrigin(const std::filesystem::path& path)
    : path_(path),
      remote_(Connect(path)),
      name_(remote_ ? remote_->Name() : path.string()),
      state_(remote_ ? FileState() : StateOf(path)) {
  try {
    WithName(path_, [this] { CheckFile(); });
  } catch (const InputError&) {
    CheckConnection();  // SQLite takes the server's failure for damage
    throw;
  }
}

void MapOrigin::CheckFile() const {
  if (!remote_) {
    CheckSqliteHeader(path_);
    CheckSchema(path_);
    return;
  }
  std::array<unsigned char, 100> header{};
  const std::uint64_t bytes = remote_->File().Read(0, header.size(), header.data());
  CheckSqliteHeader(header.data(), bytes, remote_->File().Size());
  CheckSchema(name_, RemoteDatabase::SqliteVfs());
}

std::uint64_t MapOrigin::FileBytes() const {
  return remote_ ? remote_->File().Size() : std::filesystem::file_size(path_);
}

void MapOrigin::CheckCurrent() const {
  if (remote_) {
    WithName(path_, [this] { remote_->File().CheckCurrent(); });
  } else if (StateOf(path_) != state_) {
    Throw("was replaced while it was opened; try again");
  }
}

void MapOrigin::CheckConnection() const {
  if (remote_) WithName(path_, [this] { remote_->File().RethrowFailure(); });
}

void MapOrigin::Throw(const std::string& what) const {
  CheckConnection();
  throw InputError(WithoutSecrets(path_.string()) + ": " + what);
}

}  // namespace ceilmap::store
