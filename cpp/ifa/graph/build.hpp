// Builds databases: in parallel, resumable, whole or not there.
#pragma once

#include <cstdint>
#include <filesystem>

#include "ifa/graph/database.hpp"

namespace ifa {

// How far `progress` is when all is simulated; what is left is to join the shards.
inline constexpr double kSimulatedShare = 0.95;

inline constexpr std::uint64_t kMostSimulations = 0xffffffff;

// The database of simulations 0 to `simulations` - 1 in `folder`, which is made if need be. Shards of some
// thousand simulations are written one by one, each whole or not at all, and in the end joined in the order
// of the simulations; so its bytes do not depend on the threads. However it ends before that (killed,
// cancelled, the disk full), the same call goes on from the shards that are there. A complete database is
// opened, or goes on to more simulations. Throws ArgumentError naming what differs where the folder holds a
// database, or part of one, that is of something else or of more simulations.
Database build_database(const Body& body, const Recipe& recipe, const std::filesystem::path& folder,
                        std::uint64_t simulations, int threads, Progress* progress = nullptr);

}  // namespace ifa
