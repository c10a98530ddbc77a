#include "ifa/graph/transitions.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "ifa/base/parallel.hpp"
#include "ifa/graph/flight_index.hpp"

namespace ifa {
namespace {

constexpr std::size_t kChunk = 256;  // nodes

struct Chunk {
  std::vector<std::uint32_t> count;  // of each node's
  std::vector<std::uint32_t> target;
  std::vector<std::uint16_t> cost;
  std::vector<std::uint8_t> element;
};

}  // namespace

Transitions view_of(const TransitionColumns& c) { return {c.first, c.target, c.cost, c.element}; }

TransitionColumns make_transitions(const Nodes& nodes, const Body& body, const Images& images,
                                   double gravity_m_s2, double gain_j, std::size_t most, int threads,
                                   Progress* progress) {
  std::vector<std::uint32_t> flights;
  for (std::size_t i = 0; i < nodes.size(); ++i)
    if (flies(nodes, i)) flights.push_back(static_cast<std::uint32_t>(i));
  const FlightIndex index(nodes, body, images, flights);

  std::vector<Chunk> chunks((nodes.size() + kChunk - 1) / kChunk);
  std::atomic<std::size_t> done{0};
  parallel_for(
      chunks.size(), threads,
      [&](std::size_t c) {
        Chunk& chunk = chunks[c];
        for (std::size_t i = c * kChunk; i < std::min(nodes.size(), (c + 1) * kChunk); ++i) {
          std::vector<FoundSplice> found;
          if (flies(nodes, i))
            found = index.best(i, most, [&](std::uint32_t j, const Splice& s) {
              return keeps_energy(nodes, i, j + 1, s, body, gravity_m_s2, gain_j);
            });
          chunk.count.push_back(static_cast<std::uint32_t>(found.size()));
          for (const FoundSplice& f : found) {
            chunk.target.push_back(f.node + 1);
            chunk.cost.push_back(static_cast<std::uint16_t>(std::lround(f.cost / kCostUnit)));
            chunk.element.push_back(f.element);
          }
        }
        if (progress)
          progress->raise_to(static_cast<double>(done.fetch_add(1) + 1) / static_cast<double>(chunks.size()));
      },
      progress);

  TransitionColumns all;
  std::size_t total = 0;
  for (const Chunk& chunk : chunks) total += chunk.target.size();
  all.first.reserve(nodes.size() + 1);
  all.target.reserve(total);
  all.cost.reserve(total);
  all.element.reserve(total);
  all.first.push_back(0);
  for (Chunk& chunk : chunks) {
    for (const std::uint32_t n : chunk.count) all.first.push_back(all.first.back() + n);
    all.target.insert(all.target.end(), chunk.target.begin(), chunk.target.end());
    all.cost.insert(all.cost.end(), chunk.cost.begin(), chunk.cost.end());
    all.element.insert(all.element.end(), chunk.element.begin(), chunk.element.end());
    chunk = {};
  }
  return all;
}

}  // namespace ifa
