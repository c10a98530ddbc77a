#include "ifa/forward/repairs.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "ifa/base/message.hpp"
#include "ifa/forward/candidate.hpp"

namespace ifa {
namespace {

constexpr double kShift_s = 1e-3, kMaterial = 0.01, kEnergyRatio = 1.1;  // one step of a size
constexpr int kEnergySizes = 49;  // 1.1^48 = 97: from a hundredth of all that a gap could need
constexpr double kMaterialUnit = 0.1, kWholeCost = 5.0;
constexpr double kLeastRestitution = 0.05, kMostRestitution = 0.95;
constexpr double kLeastFriction = 0.05, kMostFriction = 1.5;  // without any a body slides on for ever
constexpr double kRounding = 1e-9;

double shorter_gap_s(const Marks& marks, std::size_t k) {
  double gap_s = kNever;
  if (k > 0) gap_s = marks.times_s[k] - marks.times_s[k - 1];
  if (k + 1 < marks.size()) gap_s = std::min(gap_s, marks.times_s[k + 1] - marks.times_s[k]);
  return gap_s;
}

double shift_unit_s(const Marks& marks, std::size_t k) { return kPlausible.retime * shorter_gap_s(marks, k); }

// How far a mark can go before it is too close to its neighbour. The last one may double its gap.
double room_s(const Marks& marks, std::size_t k, int sign, double merge_gap_s) {
  const auto end_s = [&](std::size_t i) {
    return marks.times_s[i] + std::max(merge_gap_s, marks.durations_s[i]);
  };
  if (sign < 0) return marks.times_s[k] - (k > 0 ? end_s(k - 1) : 0.0);
  return k + 1 < marks.size() ? marks.times_s[k + 1] - end_s(k) : marks.times_s[k] - marks.times_s[k - 1];
}

// From half a unit of cost: the shift doubles up to half the room, then what is left of the room halves.
std::vector<int> shift_sizes(const Marks& marks, std::size_t k, int sign, double merge_gap_s) {
  constexpr int kHalvings = 3;
  const int room = static_cast<int>(std::floor(room_s(marks, k, sign, merge_gap_s) / kShift_s + kRounding));
  std::vector<int> sizes;
  int size = std::max(1, static_cast<int>(std::lround(0.5 * shift_unit_s(marks, k) / kShift_s)));
  for (; 2 * size < room; size *= 2) sizes.push_back(size);
  for (int part = 2; part <= 1 << kHalvings; part *= 2)
    if (const int most = room - room / part; most > (sizes.empty() ? 0 : sizes.back())) sizes.push_back(most);
  return sizes;
}

// Near the given value densely, since what works may be an island.
std::vector<int> material_sizes(double room) {
  const int most = static_cast<int>(std::floor(room / kMaterial + kRounding));
  std::vector<int> sizes;
  for (int size = 5; size < most; size += size < 20 ? 5 : 20) sizes.push_back(size);
  if (most > 0) sizes.push_back(most);
  return sizes;
}

double energy_j(const Request& request, const Line& line, int size) {
  return request.energy_gain_j + line.least_j * std::pow(kEnergyRatio, size - 1);
}

double material_value(double given, const Line& line, int size) {
  return given + line.sign * size * kMaterial;
}

// The energy of the bounce before the conflict that needs most: what a gain is compared with. The longest
// gap's flight, from nothing, is all that a contact could have to give.
void add_energy_line(std::vector<Line>& lines, const std::vector<Conflict>& conflicts,
                     const Estimate& estimate) {
  std::size_t mark = 0;
  double before_j = 0.0, most_j = 0.0;
  for (const GapEstimate& gap : estimate.gaps) most_j = std::max(most_j, gap.energy_j);
  for (const Conflict& c : conflicts) {
    if (c.mark == 0 || (c.kind != ConflictKind::missed && c.kind != ConflictKind::implausible &&
                        c.kind != ConflictKind::retimed))
      continue;
    const double own_j = estimate.gaps[std::max<std::size_t>(c.mark, 2) - 2].energy_j;
    if (mark > 0 && own_j <= before_j) continue;
    mark = c.mark;
    before_j = own_j;
  }
  if (mark == 0 || most_j == 0.0) return;  // spans all the way: nothing flies
  const double retimed = 1.0 + kPlausible.retime;
  lines.push_back({RepairKind::energy,
                   mark,
                   1,
                   most_j / std::pow(kEnergyRatio, kEnergySizes - 1),
                   (retimed * retimed - 1.0) * (before_j > 0.0 ? before_j : most_j),
                   {kEnergySizes}});
}

void drop(std::vector<double>& values, std::size_t k) {
  if (!values.empty()) values.erase(values.begin() + static_cast<std::ptrdiff_t>(k));
}

}  // namespace

std::string_view name_of(RepairKind kind) {
  constexpr std::string_view kNames[] = {"shift", "drop", "energy", "restitution", "friction", "ending"};
  return kNames[static_cast<std::size_t>(kind)];
}

std::string_view unit_of(RepairKind kind) {
  constexpr std::string_view kUnits[] = {"s", "mark", "J", "", "", ""};
  return kUnits[static_cast<std::size_t>(kind)];
}

std::vector<Line> lines_for(const Request& request, const std::vector<Conflict>& conflicts,
                            const Estimate& estimate, double merge_gap_s) {
  const Marks& marks = request.marks;
  const std::size_t n = marks.size();
  std::set<std::size_t> to_shift, to_drop;
  bool rest_fails = false;
  for (const Conflict& c : conflicts) {
    rest_fails |= marks.ending == Ending::rest && c.mark == n - 1 && c.kind != ConflictKind::missed;
    for (std::size_t k = c.mark > 0 ? c.mark - 1 : 0; k <= std::min(c.mark + 1, n - 1); ++k) {
      if (c.kind != ConflictKind::sound) to_shift.insert(k);
      if (c.kind != ConflictKind::sound || k == c.mark) to_drop.insert(k);
    }
  }
  std::vector<Line> lines;
  const auto add = [&](RepairKind kind, std::size_t mark, int sign, std::vector<int> sizes) {
    if (!sizes.empty()) lines.push_back({kind, mark, sign, 0.0, 0.0, std::move(sizes)});
  };
  if (n > 1) {
    for (const std::size_t k : to_shift)
      for (const int sign : {-1, 1})
        add(RepairKind::shift, k, sign, shift_sizes(marks, k, sign, std::max(merge_gap_s, kMergeGap_s)));
    for (const std::size_t k : to_drop)
      if (k > 0 || marks.amplitudes.empty() || marks.amplitudes[1] > 0.0) add(RepairKind::drop, k, 1, {1});
    add_energy_line(lines, conflicts, estimate);
  }
  if (!request.fit_material) {
    const Material& m = request.body.material();
    add(RepairKind::restitution, 0, -1, material_sizes(m.restitution - kLeastRestitution));
    add(RepairKind::restitution, 0, 1, material_sizes(kMostRestitution - m.restitution));
    add(RepairKind::friction, 0, -1, material_sizes(m.friction - kLeastFriction));
    add(RepairKind::friction, 0, 1, material_sizes(kMostFriction - m.friction));
  }
  if (rest_fails) add(RepairKind::ending, n - 1, 1, {1});
  return lines;
}

Request changed(const Request& request, const Line& line, int size) {
  Request out = request;
  const std::size_t k = line.mark;
  Material material = request.body.material();
  switch (line.kind) {
    case RepairKind::shift:
      out.marks.times_s[k] = std::max(0.0, out.marks.times_s[k] + amount(request, line, size));
      break;
    case RepairKind::drop:
      drop(out.marks.times_s, k);
      drop(out.marks.durations_s, k);
      drop(out.marks.amplitudes, k);
      drop(out.marks.centroids_s, k);
      out.marks.constraints.forget_mark(k);
      break;
    case RepairKind::energy:
      out.energy_gain_j = energy_j(request, line, size);
      break;
    case RepairKind::restitution:
      material.restitution = material_value(material.restitution, line, size);
      break;
    case RepairKind::friction:
      material.friction = material_value(material.friction, line, size);
      break;
    case RepairKind::ending:
      out.marks.ending = Ending::open;
      out.marks.constraints.forget_rest();
      break;
  }
  if (line.kind == RepairKind::restitution || line.kind == RepairKind::friction)
    out.body = request.body.with_material(material);
  return out;
}

double amount(const Request& request, const Line& line, int size) {
  switch (line.kind) {
    case RepairKind::shift:
      return line.sign * size * kShift_s;
    case RepairKind::energy:
      return energy_j(request, line, size) - request.energy_gain_j;
    case RepairKind::restitution:
    case RepairKind::friction:
      return line.sign * size * kMaterial;
    case RepairKind::drop:
    case RepairKind::ending:
      break;
  }
  return 1.0;
}

double cost(const Request& request, const Line& line, int size) {
  switch (line.kind) {
    case RepairKind::shift:
      return size * kShift_s / shift_unit_s(request.marks, line.mark);
    case RepairKind::energy:
      return amount(request, line, size) / line.unit_j;
    case RepairKind::restitution:
    case RepairKind::friction:
      return size * kMaterial / kMaterialUnit;
    case RepairKind::drop:
    case RepairKind::ending:
      break;
  }
  return kWholeCost;
}

std::string text_of(const Request& request, const Line& line, int size) {
  const double from_s = request.marks.times_s[line.mark];
  const Request to = changed(request, line, size);
  const Material &was = request.body.material(), &is = to.body.material();
  switch (line.kind) {
    case RepairKind::shift:
      return "move mark " + std::to_string(line.mark + 1) + " by " + std::to_string(line.sign * size) +
             " ms: " + seconds(from_s) + " -> " + seconds(to.marks.times_s[line.mark]);
    case RepairKind::drop:
      return "drop " + mark_name(line.mark, from_s);
    case RepairKind::energy:
      return "allow each contact to add " + measure(to.energy_gain_j, "J") +
             (request.energy_gain_j > 0.0 ? " instead of " + measure(request.energy_gain_j, "J") : "");
    case RepairKind::restitution:
      return "restitution " + number(is.restitution) + " instead of " + number(was.restitution);
    case RepairKind::friction:
      return "friction " + number(is.friction) + " instead of " + number(was.friction);
    case RepairKind::ending:
      break;
  }
  return "let it end open: ask for nothing after " + mark_name(line.mark, from_s);
}

}  // namespace ifa
