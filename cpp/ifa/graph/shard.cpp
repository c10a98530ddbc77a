#include "ifa/graph/shard.hpp"

#include <cstdio>
#include <cstring>
#include <string>

#include "ifa/base/error.hpp"
#include "ifa/graph/checksum.hpp"

namespace ifa {
namespace {

namespace fs = std::filesystem;

// Then come the columns, one after the other, and the checksum of all before it.
struct Header {
  char format[8] = {'i', 'f', 'a', 's', 'h', 'r', 'd', '1'};
  ShardId id;
  std::uint64_t rows;
};

template <class T>
std::span<const std::byte> bytes_of(const T& value) {
  return std::as_bytes(std::span(&value, 1));
}

}  // namespace

fs::path shard_path(const fs::path& folder, const ShardId& id) {
  char name[48];
  std::snprintf(name, sizeof name, "%010llu-%llu.shard", static_cast<unsigned long long>(id.first),
                static_cast<unsigned long long>(id.count));
  return folder / name;
}

void write_shard(const fs::path& folder, const ShardId& id, const NodeColumns& nodes) {
  const fs::path path = shard_path(folder, id);
  NewFile file(path);
  Checksum sum;
  const auto write = [&](std::span<const std::byte> bytes) {
    file.write(bytes);
    sum.add(bytes);
  };
  Header header;
  header.id = id;
  header.rows = nodes.size();
  write(bytes_of(header));
  NodeColumns::each(nodes,
                    [&](const auto& column, int, const char*) { write(std::as_bytes(std::span(column))); });
  file.write(bytes_of(sum.value()));
  file.keep_as(path);
}

std::optional<Shard> read_shard(const fs::path& folder, const ShardId& id) {
  const fs::path path = shard_path(folder, id);
  std::error_code error;
  if (!fs::exists(path, error)) return std::nullopt;
  Shard shard{std::make_shared<MappedFile>(path), {}};
  std::span<const std::byte> bytes = shard.file->bytes();
  if (bytes.size() < sizeof(Header) + sizeof(std::uint64_t)) return std::nullopt;
  std::uint64_t sum;
  std::memcpy(&sum, bytes.last(sizeof sum).data(), sizeof sum);
  bytes = bytes.first(bytes.size() - sizeof sum);
  if (checksum(bytes) != sum) return std::nullopt;
  Header header;
  std::memcpy(&header, bytes.data(), sizeof header);
  if (std::memcmp(header.format, Header{}.format, sizeof header.format) != 0 || header.id != id)
    return std::nullopt;
  bytes = bytes.subspan(sizeof header);
  bool whole = true;
  // The columns come in falling order of their numbers' size, so each is aligned.
  Nodes::each(shard.nodes, [&]<class T>(std::span<const T>& column, int width, const char*) {
    const std::size_t numbers = header.rows * static_cast<std::size_t>(width);
    whole = whole && bytes.size() / sizeof(T) >= numbers;
    if (!whole) return;
    column = {reinterpret_cast<const T*>(bytes.data()), numbers};
    bytes = bytes.subspan(numbers * sizeof(T));
  });
  if (!whole || !bytes.empty()) return std::nullopt;
  return shard;
}

}  // namespace ifa
