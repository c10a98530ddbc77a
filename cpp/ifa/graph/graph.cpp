#include "ifa/graph/graph.hpp"

#include <string>

namespace ifa {
namespace {

constexpr const char* kSet = "transitions";
constexpr const char* kMade = "made_by";  // which rules made them: a change of the weights is another number
constexpr const char* kRules = "1";
constexpr const char* kOf = "of_nodes";  // the sum of the nodes that they were made of
constexpr std::size_t kMost = 32;        // of each node

// What the nodes are, as their manifest has it.
std::string sum_of(const Database& database) {
  std::string sum;
  for (const ArrayInfo& array : database.files().arrays()) {
    sum += '-';
    sum += std::to_string(array.checksum);
  }
  return sum;
}

std::optional<ArraySet> kept_of(const Database& database) {
  if (!ArraySet::exists(database.folder(), kSet)) return std::nullopt;
  ArraySet set = ArraySet::open(database.folder(), kSet);
  if (set.field(kMade) != kRules || set.field(kOf) != sum_of(database)) return std::nullopt;
  return set;
}

void keep(const Database& database, const TransitionColumns& t) {
  const FolderLock lock(database.folder());
  NewArraySet set(lock, kSet);
  set.append("first", 1, std::span<const std::uint64_t>(t.first));
  set.append("target", 1, std::span<const std::uint32_t>(t.target));
  set.append("cost", 1, std::span<const std::uint16_t>(t.cost));
  set.append("element", 1, std::span<const std::uint8_t>(t.element));
  set.commit({{kMade, kRules}, {kOf, sum_of(database)}});
}

Transitions view_of(const ArraySet& set) {
  return {set.array<std::uint64_t>("first", 1), set.array<std::uint32_t>("target", 1),
          set.array<std::uint16_t>("cost", 1), set.array<std::uint8_t>("element", 1)};
}

}  // namespace

ContactGraph ContactGraph::of(const Database& database, double energy_gain_j, int threads,
                              Progress* progress) {
  auto parts = std::make_shared<Parts>(
      Parts{database, Images(Symmetry::of(database.body())), Briefs(database.nodes()), {}, {}, {}});
  if (energy_gain_j == 0.0) parts->kept = kept_of(database);
  if (!parts->kept) {
    parts->made = make_transitions(database.nodes(), database.body(), parts->images,
                                   database.physics().simulation.gravity_m_s2.norm(), energy_gain_j, kMost,
                                   threads, progress);
    if (energy_gain_j == 0.0) {
      try {
        keep(database, parts->made);
        parts->kept = ArraySet::open(database.folder(), kSet);
        parts->made = {};
      } catch (const FileError&) {  // a database that is only to be read serves as well
      }
    }
  }
  parts->transitions = parts->kept ? view_of(*parts->kept) : view_of(parts->made);
  return ContactGraph(parts);
}

const NodeTrees& ContactGraph::trees() const {
  Parts::LazyTrees& trees = *parts_->trees;
  std::call_once(trees.once, [&] { trees.made.emplace(database().nodes(), database().body()); });
  return *trees.made;
}

}  // namespace ifa
