#include "ifa/graph/build.hpp"

#include <algorithm>
#include <atomic>
#include <optional>
#include <utility>
#include <vector>

#include "ifa/base/error.hpp"
#include "ifa/base/parallel.hpp"
#include "ifa/graph/harvest.hpp"
#include "ifa/graph/shard.hpp"

namespace ifa {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kShardSimulations = 1024;  // of a die some 50 ms and 2 MB, of a coin 5 s
constexpr const char* kPlan = "plan";              // the manifest of a build: what its shards are of

void make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directory(folder, error);
  if (error) throw FileError(folder.string() + ": cannot be made: " + error.message());
  sync_folder(fs::absolute(folder).parent_path());
}

// A folder that is new, empty or our own: a build shall not strew its files among others.
void claim(const fs::path& folder) {
  std::error_code error;
  const fs::file_status status = fs::status(folder, error);
  if (status.type() == fs::file_type::not_found) return make_folder(folder);
  const std::string name = folder.string();
  if (status.type() != fs::file_type::directory) throw FileError(name + ": is not a folder");
  if (ArraySet::exists(folder, Database::kSet) || fs::exists(folder / kShardFolder, error)) return;
  if (!fs::is_empty(folder, error) && !error)
    throw FileError(name + ": holds other files; a database needs a folder of its own");
}

void need_same(const Fields& theirs, const Fields& ours, const fs::path& folder) {
  const std::string name = difference(theirs, ours);
  if (name == "engine")
    throw ArgumentError("path: " + folder.string() +
                        " was begun by another version of ifa or on another processor, whose simulations "
                        "differ; choose another folder");
  if (!name.empty())
    throw ArgumentError(difference_text(name, theirs, ours, folder) + "; choose another folder");
}

// Writes or compares the plan of a build.
void plan(const fs::path& shards, const Fields& fields, const fs::path& folder) {
  const fs::path path = shards / kPlan;
  std::error_code error;
  if (fs::exists(path, error))
    need_same(from_text(read_text(path), path).first, fields, folder);
  else
    write_whole(path, to_text(fields, {}));
}

void remove_shards(const fs::path& shards) {
  std::error_code error;
  fs::remove_all(shards, error);
  if (error) throw FileError(shards.string() + ": cannot be removed: " + error.message());
}

Fields without(Fields fields, const std::string& name) {
  std::erase_if(fields, [&](const auto& field) { return field.first == name; });
  return fields;
}

class Build {
 public:
  Build(const Body& body, const Recipe& recipe, fs::path shards, const Fields& fields, std::uint64_t from,
        std::uint64_t to, Progress* progress)
      : body_(body), recipe_(recipe), shards_(std::move(shards)), to_(to), progress_(progress) {
    const std::string text = to_text(without(fields, "name"), {});
    const std::uint64_t hash = checksum(std::as_bytes(std::span(text)));
    while (from < to) {
      const std::uint64_t end = std::min(to, (from / kShardSimulations + 1) * kShardSimulations);
      all_.push_back({hash, from, end - from});
      from = end;
    }
  }

  void simulate(int threads) {
    std::vector<char> there(all_.size());
    parallel_for(
        all_.size(), threads, [&](std::size_t i) { there[i] = read_shard(shards_, all_[i]).has_value(); },
        progress_);
    std::vector<ShardId> missing;
    std::atomic<std::uint64_t> done = to_;
    for (std::size_t i = 0; i < all_.size(); ++i) {
      if (there[i]) continue;
      missing.push_back(all_[i]);
      done -= all_[i].count;
    }
    const auto raise = [&] {
      if (progress_)
        progress_->raise_to(kSimulatedShare * static_cast<double>(done) / static_cast<double>(to_));
    };
    raise();
    const auto make = [&](std::size_t i) {
      const ShardId& id = missing[i];
      write_shard(shards_, id,
                  harvest(body_, recipe_.physics, recipe_.sampling, recipe_.seed, id.first, id.count,
                          recipe_.until_s, progress_));
      done += id.count;
      raise();
    };
    parallel_for(missing.size(), threads, make, progress_);
  }

  // `before`, where there is one, has the simulations before those of the shards.
  void join(const FolderLock& lock, const Fields& fields, const Database* before) {
    NewArraySet set(lock, Database::kSet);
    const auto add = [&](const Nodes& nodes) {
      Nodes::each(nodes, [&](const auto& column, int width, const char* name) {
        set.append(name, static_cast<std::size_t>(width), column);
      });
    };
    add(before ? before->nodes() : Nodes{});
    for (std::size_t i = 0; i < all_.size(); ++i) {
      if (progress_) progress_->throw_if_cancelled();
      const auto shard = read_shard(shards_, all_[i]);
      if (!shard)
        throw FileError(shard_path(shards_, all_[i]).string() + ": has been damaged or removed meanwhile");
      add(shard->nodes);
      const double share = static_cast<double>(i + 1) / static_cast<double>(all_.size());
      if (progress_) progress_->raise_to(kSimulatedShare + (1.0 - kSimulatedShare) * share);
    }
    Fields said = fields;
    said.emplace_back(kSimulations, std::to_string(to_));
    set.commit(said);
  }

 private:
  const Body& body_;
  const Recipe& recipe_;
  fs::path shards_;
  std::uint64_t to_;
  Progress* progress_;
  std::vector<ShardId> all_;
};

}  // namespace

Database build_database(const Body& given, const Recipe& recipe, const fs::path& path,
                        std::uint64_t simulations, int threads, Progress* progress) {
  validate(recipe);
  if (simulations < 1 || simulations > kMostSimulations)
    throw ArgumentError("simulations: must be from 1 to " + std::to_string(kMostSimulations));
  const fs::path folder = fs::absolute(path), shards = folder / kShardFolder;
  const Body body = settled(given);
  const Fields fields = to_fields(body, recipe);
  claim(folder);
  const FolderLock lock(folder);

  std::optional<Database> before;
  if (ArraySet::exists(folder, Database::kSet)) {
    before = Database::open(folder);
    need_same(without(before->files().fields(), kSimulations), fields, folder);
    if (before->simulations() > simulations)
      throw ArgumentError("simulations: " + folder.string() + " has " +
                          std::to_string(before->simulations()) + ", not " + std::to_string(simulations) +
                          "; choose another folder");
  }
  const std::uint64_t from = before ? before->simulations() : 0;
  if (from < simulations) {
    std::error_code error;
    if (!fs::exists(shards, error)) make_folder(shards);
    plan(shards, fields, folder);
    Build build(body, recipe, shards, fields, from, simulations, progress);
    build.simulate(threads);
    build.join(lock, fields, before ? &*before : nullptr);
    before.reset();
  }
  remove_shards(shards);
  if (progress) progress->raise_to(1.0);
  return Database::open(folder);
}

}  // namespace ifa
