#include "app/bags/chunked_bag.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <tuple>
#include <utility>

#include "app/bags/record_cursor.hpp"

namespace ceilmap::bags {

struct ChunkedBag::OpenChunk {
  std::size_t place = 0;
  ChunkContent content;
  bool loaded = false;
  std::size_t passed = 0;    // messages that were returned
  std::int64_t next_ns = 0;  // of the first that was not

  [[nodiscard]] auto Order() const { return std::tuple(next_ns, place); }
  [[nodiscard]] std::uint64_t Bytes() const {
    return content.bytes.Capacity() + content.messages.capacity() * sizeof(StoredMessage);
  }
};

namespace {

// Of std::push_heap, which puts the largest first.
constexpr auto kLater = [](const auto& a, const auto& b) { return a->Order() > b->Order(); };

}  // namespace

ChunkedBag::ChunkedBag(const std::filesystem::path& path, std::string name)
    : file_(path, std::move(name)), warnings_(file_.Name()) {}

ChunkedBag::~ChunkedBag() = default;

void ChunkedBag::AddCompression(std::string_view name) {
  // "none" is not listed beside others.
  if (name.empty() || name == "none") name = "none";
  std::string& all = facts_.compression;
  if (all.empty() || all == "none") {
    all = name;
  } else if (name != "none" && all.find(name) == std::string::npos) {
    all = all < name ? all + ", " + std::string(name) : std::string(name) + ", " + all;
  }
}

void ChunkedBag::AddTime(std::int64_t first_ns, std::int64_t last_ns) {
  facts_.first_ns = std::min(facts_.first_ns.value_or(first_ns), first_ns);
  facts_.last_ns = std::max(facts_.last_ns.value_or(last_ns), last_ns);
}

void ChunkedBag::AddMessage(ChunkPlace& place, std::int64_t log_time_ns, std::uint32_t topic) {
  // A place without topics has no messages so far.
  const bool first = place.topics.empty();
  place.first_ns = first ? log_time_ns : std::min(place.first_ns, log_time_ns);
  place.last_ns = first ? log_time_ns : std::max(place.last_ns, log_time_ns);
  if (seen_in_.size() <= topic) seen_in_.resize(topic + 1, 0);
  if (seen_in_[topic] != place.offset) place.topics.push_back(topic);
  seen_in_[topic] = place.offset;  // not 0, where the file's magic is
  topics_.Count(topic, 1);
  AddTime(log_time_ns, log_time_ns);
}

bool ChunkedBag::Disjoint() {
  std::sort(places_.begin(), places_.end(), [](const ChunkPlace& a, const ChunkPlace& b) {
    return a.offset < b.offset;
  });
  for (std::size_t i = 1; i < places_.size(); ++i) {
    if (places_[i].offset - places_[i - 1].offset < places_[i - 1].length) return false;
  }
  return true;
}

bool ChunkedBag::ReadPacked(std::uint64_t at,
                            std::uint64_t packed_size,
                            Compression compression,
                            std::uint64_t size,
                            Buffer& unpacked) {
  if (packed_size > kMaxChunkBytes) {
    throw DamagedBytes(
        fmt::format("has {} MB, more than {}", packed_size >> 20U, kMaxChunkBytes >> 20U));
  }
  const bool copied = compression == Compression::kNone;
  Buffer& read = copied ? unpacked : packed_;
  read.Resize(static_cast<std::size_t>(packed_size));
  file_.Read(at, read.Bytes());
  return copied ? packed_size == size : Decompress(compression, read.Bytes(), size, unpacked);
}

void ChunkedBag::Start() {
  topics_.Sort();
  wanted_.assign(topics_.Size(), 1);
  if (facts_.compression.empty()) facts_.compression = "none";
  std::stable_sort(places_.begin(), places_.end(), [](const ChunkPlace& a, const ChunkPlace& b) {
    return a.first_ns < b.first_ns;
  });
  Rewind();
}

void ChunkedBag::Select(const std::vector<std::size_t>& topics) {
  std::vector<char> selected(topics_.Size(), 0);
  for (const std::size_t place : topics) selected.at(place) = 1;
  for (std::uint32_t number = 0; number < wanted_.size(); ++number) {
    wanted_[number] = selected[topics_.Place(number)];
  }
  Rewind();
}

void ChunkedBag::Rewind() {
  open_.clear();
  given_ = false;
  next_place_ = 0;
}

bool ChunkedBag::Due(const ChunkPlace& place) const {
  return open_.empty() || place.first_ns <= open_.front()->next_ns;
}

bool ChunkedBag::Next(RawMessage& message) {
  if (given_) PassGiven();
  while (true) {
    while (next_place_ < places_.size() && Due(places_[next_place_])) Open(next_place_++);
    if (open_.empty()) return false;
    OpenChunk& chunk = *open_.front();
    if (!chunk.loaded) LoadSorted(chunk);
    if (chunk.passed < chunk.content.messages.size()) {
      const StoredMessage& stored = chunk.content.messages[chunk.passed];
      message.topic = topics_.Place(stored.topic);
      message.log_time_ns = stored.log_time_ns;
      message.data =
          chunk.content.bytes.Bytes().subspan(static_cast<std::size_t>(stored.offset), stored.size);
      given_ = true;
      if (unpacker_.Unpack(message, topics_.At(stored.topic), warnings_)) return true;
      PassGiven();
      continue;
    }
    // The file was changed between two reads of the chunk.
    std::pop_heap(open_.begin(), open_.end(), kLater);
    open_.pop_back();
  }
}

// The message that was returned last is passed: the next of its chunk, or the end of it.
void ChunkedBag::PassGiven() {
  given_ = false;
  std::pop_heap(open_.begin(), open_.end(), kLater);
  std::unique_ptr<OpenChunk> chunk = std::move(open_.back());
  open_.pop_back();
  ++chunk->passed;
  if (chunk->passed == chunk->content.messages.size()) {
    Close(std::move(chunk));
    return;
  }
  chunk->next_ns = chunk->content.messages[chunk->passed].log_time_ns;
  open_.push_back(std::move(chunk));
  std::push_heap(open_.begin(), open_.end(), kLater);
}

void ChunkedBag::Open(std::size_t place) {
  const std::vector<std::uint32_t>& topics = places_[place].topics;
  const auto wanted = [&](std::uint32_t topic) { return Wanted(topic); };
  if (!topics.empty() && std::none_of(topics.begin(), topics.end(), wanted)) return;
  auto chunk = std::make_unique<OpenChunk>();
  chunk->place = place;
  LoadSorted(*chunk);
  if (chunk->content.messages.empty()) {
    Close(std::move(chunk));
    return;
  }
  chunk->next_ns = chunk->content.messages.front().log_time_ns;
  open_.push_back(std::move(chunk));
  std::push_heap(open_.begin(), open_.end(), kLater);
}

void ChunkedBag::LoadSorted(OpenChunk& chunk) {
  if (!spare_.empty()) {
    chunk.content = std::move(spare_.back());
    spare_.pop_back();
  }
  chunk.content.bytes.Resize(0);
  chunk.content.messages.clear();
  MakeRoom(chunk, places_[chunk.place].length);
  Load(places_[chunk.place], chunk.content);
  chunk.loaded = true;
  const auto earlier = [](const StoredMessage& a, const StoredMessage& b) {
    return a.log_time_ns < b.log_time_ns;
  };
  std::vector<StoredMessage>& messages = chunk.content.messages;
  if (!std::is_sorted(messages.begin(), messages.end(), earlier)) {
    std::stable_sort(messages.begin(), messages.end(), earlier);
  }
  MakeRoom(chunk, chunk.Bytes());
}

// Where many large chunks overlap, those whose turn is last give up their memory, and are read
// again when it comes. The chunk `kept`, which takes `bytes`, keeps its own.
void ChunkedBag::MakeRoom(const OpenChunk& kept, std::uint64_t bytes) {
  constexpr std::uint64_t kMaxBytes = std::uint64_t{160} << 20U;
  std::uint64_t used = bytes;
  for (const auto& chunk : open_) {
    if (chunk.get() != &kept && chunk->loaded) used += chunk->Bytes();
  }
  while (used > kMaxBytes) {
    OpenChunk* last = nullptr;
    for (const auto& chunk : open_) {
      if (chunk.get() == &kept || !chunk->loaded) continue;
      if (last == nullptr || chunk->Order() > last->Order()) last = chunk.get();
    }
    if (last == nullptr) return;
    used -= last->Bytes();
    last->content = {};
    last->loaded = false;
  }
}

void ChunkedBag::Close(std::unique_ptr<OpenChunk> chunk) {
  constexpr std::size_t kMaxSpares = 2;
  constexpr std::size_t kMaxSpareBytes = std::size_t{32} << 20U;
  if (chunk->loaded && spare_.size() < kMaxSpares && chunk->Bytes() <= kMaxSpareBytes) {
    spare_.push_back(std::move(chunk->content));
  }
}

bool ChunkedBag::ScanLoose(std::uint64_t at, std::uint64_t length) {
  constexpr std::uint64_t kLooseBytes = std::uint64_t{4} << 20U;
  if (length > kMaxChunkBytes) {
    Warn(fmt::format("a message of {} MB at byte {} is skipped", length >> 20U, at));
    loose_open_ = false;
    return false;
  }
  if (!loose_open_ || places_.back().length + length > kLooseBytes) {
    places_.emplace_back();
    places_.back().offset = at;
    places_.back().loose = true;
    loose_open_ = true;
    AddCompression("none");
  }
  places_.back().length += length;
  return true;
}

void ChunkedBag::AddLoose(std::int64_t log_time_ns, std::uint32_t topic) {
  AddMessage(places_.back(), log_time_ns, topic);
  ++scanned_messages_;
}

void ChunkedBag::ScanChunk(std::uint64_t at, std::uint64_t length, bool cut) {
  loose_open_ = false;
  ChunkPlace place;
  place.offset = at;
  place.length = length;
  place.cut = cut;
  ChunkContent content;
  Load(place, content);
  for (const StoredMessage& message : content.messages) {
    AddMessage(place, message.log_time_ns, message.topic);
  }
  scanned_messages_ += content.messages.size();
  if (!content.messages.empty()) places_.push_back(std::move(place));
}

void ChunkedBag::Load(const ChunkPlace& place, ChunkContent& content) {
  try {
    if (place.loose) {
      content.bytes.Resize(static_cast<std::size_t>(place.length));
      file_.Read(place.offset, content.bytes.Bytes());
      ListMessages(content, place, true);
    } else {
      LoadChunk(place, content);
    }
  } catch (const DamagedBytes& damage) {
    content.messages.clear();
    if (place.cut) return;  // is reported by Scan
    Warn(fmt::format("the chunk at byte {} is skipped: it {}", place.offset, damage.what()));
  }
}

}  // namespace ceilmap::bags
