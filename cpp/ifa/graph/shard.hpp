// The nodes of some successive simulations, in one file, while a database is being built.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>

#include "ifa/graph/files.hpp"
#include "ifa/graph/nodes.hpp"

namespace ifa {

struct ShardId {
  std::uint64_t recipe;        // a hash of what the simulations follow from
  std::uint64_t first, count;  // simulations

  bool operator==(const ShardId&) const = default;
};

std::filesystem::path shard_path(const std::filesystem::path& folder, const ShardId& id);

void write_shard(const std::filesystem::path& folder, const ShardId& id, const NodeColumns& nodes);

struct Shard {
  std::shared_ptr<const MappedFile> file;
  Nodes nodes;  // in it
};

// None where there is no such shard, or only a damaged one.
std::optional<Shard> read_shard(const std::filesystem::path& folder, const ShardId& id);

}  // namespace ifa
