// The database of a body: the nodes of many random simulations, mapped from files (paper section 5.1).
#pragma once

#include <cstdint>
#include <filesystem>

#include "ifa/graph/array_set.hpp"
#include "ifa/graph/nodes.hpp"
#include "ifa/graph/recipe.hpp"

namespace ifa {

// Copies share the mapped files, which stay until the last copy has gone. Trajectories are not stored: see
// replay.hpp.
class Database {
 public:
  static constexpr const char* kSet = "nodes";  // of its arrays

  // At once, however large it is: the columns are looked at when they are used, and `check` compares them
  // with their checksums. Throws FileError where there is no database, or a foreign or damaged one.
  static Database open(const std::filesystem::path& folder);

  const std::filesystem::path& folder() const { return folder_; }
  const Nodes& nodes() const { return nodes_; }
  Nodes nodes_of_first(std::uint64_t simulations) const;  // the database that so many would have made
  const Body& body() const { return body_; }
  const Recipe& recipe() const { return recipe_; }
  const SearchPhysics& physics() const { return recipe_.physics; }
  std::uint64_t simulations() const { return simulations_; }
  const ArraySet& files() const { return files_; }

  // Throws ArgumentError where `body`, apart from its name, is not the one that it was built of.
  void need_body(const Body& body) const;

  void check(int threads, Progress* progress = nullptr) const { files_.check(threads, progress); }

 private:
  Database(std::filesystem::path folder, ArraySet files);

  std::filesystem::path folder_;
  ArraySet files_;
  Body body_;
  Recipe recipe_;
  std::uint64_t simulations_ = 0;
  Nodes nodes_;
};

// Of a database's folder: where it is built, and the field that says how many simulations it has.
inline constexpr const char* kShardFolder = "shards";
inline constexpr const char* kSimulations = "simulations";

}  // namespace ifa
