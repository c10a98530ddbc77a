#include "ifa/graph/database.hpp"

#include <algorithm>
#include <charconv>
#include <utility>

#include "ifa/base/error.hpp"

namespace ifa {
namespace {

namespace fs = std::filesystem;

}  // namespace

Database::Database(fs::path folder, ArraySet files)
    : folder_(std::move(folder)),
      files_(std::move(files)),
      body_(body_from(files_.fields(), folder_)),
      recipe_(recipe_from(files_.fields(), folder_)) {
  const std::string& simulations = files_.field(kSimulations);
  const auto [end, error] =
      std::from_chars(simulations.data(), simulations.data() + simulations.size(), simulations_);
  if (error != std::errc() || *end != '\0')
    throw FileError(folder_.string() + ": its number of simulations cannot be read");
  Nodes::each(nodes_, [&]<class T>(std::span<const T>& column, int width, const char* name) {
    column = files_.array<T>(name, static_cast<std::size_t>(width));
  });
  Nodes::each(nodes_, [&](const auto& column, int width, const char* name) {
    if (column.size() != nodes_.size() * static_cast<std::size_t>(width))
      throw FileError(folder_.string() + ": is damaged: its array " + name + " has another number of rows");
  });
}

Database Database::open(const fs::path& folder) {
  std::error_code error;
  const std::string name = folder.string();
  const fs::file_status status = fs::status(folder, error);
  if (status.type() == fs::file_type::not_found) throw FileError(name + ": there is no such folder");
  if (status.type() != fs::file_type::directory)
    throw FileError(name + ": is not a folder, as a database is");
  if (!ArraySet::exists(folder, kSet)) {
    if (fs::exists(folder / kShardFolder, error))
      throw FileError(name + ": is not complete; the same build goes on with it");
    throw FileError(name + ": is not a database");
  }
  return {folder, ArraySet::open(folder, kSet)};
}

Nodes Database::nodes_of_first(std::uint64_t simulations) const {
  const auto rows = static_cast<std::size_t>(
      std::ranges::lower_bound(nodes_.simulation, simulations, {},
                               [](std::uint32_t s) { return static_cast<std::uint64_t>(s); }) -
      nodes_.simulation.begin());
  Nodes first = nodes_;
  Nodes::each(first, [&](auto& column, int width, const char*) {
    column = column.first(rows * static_cast<std::size_t>(width));
  });
  return first;
}

void Database::need_body(const Body& body) const {
  const Fields theirs = to_fields(body_, recipe_), ours = to_fields(settled(body), recipe_);
  const std::string name = difference(theirs, ours);
  if (!name.empty())
    throw ArgumentError("body: is not that of the database: " + difference_text(name, theirs, ours, folder_));
}

}  // namespace ifa
