#include "ifa/graph/recipe.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "ifa/base/error.hpp"
#include "ifa/graph/harvest.hpp"

namespace ifa {
namespace {

namespace fs = std::filesystem;

constexpr const char* kName = "name";

std::string text_of(double value) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, value).ptr};  // the shortest that reads back the same
}

std::string text_of(std::uint64_t value) { return std::to_string(value); }

template <class Numbers>
std::string row_of(const Numbers& numbers) {
  std::string text;
  for (const double x : numbers) text.append(text.empty() ? "" : " ").append(text_of(x));
  return text;
}

std::string hex(std::uint64_t value) {
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(value));
  return text;
}

// One line of a name that may hold anything.
std::string escaped(const std::string& name) {
  std::string text;
  for (const char c : name) {
    char code[4];
    if (c == '%' || static_cast<unsigned char>(c) < 0x20) {
      std::snprintf(code, sizeof code, "%%%02x", static_cast<unsigned>(c));
      text += code;
    } else {
      text += c;
    }
  }
  return text;
}

std::string unescaped(const std::string& text) {
  std::string name;
  for (std::size_t i = 0; i < text.size(); ++i) {
    unsigned code = 0;
    const bool coded = text[i] == '%' && i + 2 < text.size();
    if (coded && std::from_chars(&text[i + 1], &text[i + 1] + 2, code, 16).ec == std::errc()) {
      name += static_cast<char>(code);
      i += 2;
    } else {
      name += text[i];
    }
  }
  return name;
}

Fields shape_fields(const Body::Definition& d) {
  std::vector<double> vertices, rings;
  for (const Vec3& v : d.vertices_m) vertices.insert(vertices.end(), v.begin(), v.end());
  for (const Ring& ring : d.rings_m) {
    rings.insert(rings.end(), ring.centre_m.begin(), ring.centre_m.end());
    rings.insert(rings.end(), ring.axis.begin(), ring.axis.end());
    rings.push_back(ring.radius_m);
  }
  return {{"vertices_m", row_of(vertices)},
          {"rings_m", row_of(rings)},
          {"radius_m", text_of(d.radius_m)},
          {"mass_kg", text_of(d.mass_kg)},
          {"centre_of_mass_m", row_of(d.centre_of_mass_m)},
          {"inertia_kg_m2", row_of(d.inertia_kg_m2.reshaped())}};
}

Fields material_fields(const Material& m) {
  return {{"restitution", text_of(m.restitution)},
          {"friction", text_of(m.friction)},
          {"rolling_friction_m", text_of(m.rolling_friction_m)},
          {"spin_friction_m", text_of(m.spin_friction_m)}};
}

std::string hash_of(const Fields& fields) {
  std::string text;
  for (const auto& [name, value] : fields) text += name + " " + value + "\n";
  return hex(checksum(std::as_bytes(std::span(text))));
}

// Reads the values of fields, in messages as those of a file.
class Reader {
 public:
  Reader(const Fields& fields, const fs::path& path) : fields_(fields), path_(path) {}

  std::vector<double> row(const std::string& name) const {
    const std::string& text = value_of(fields_, name, path_);
    std::vector<double> row;
    const char *at = text.data(), *const end = at + text.size();
    while (at != end) {
      double x = 0.0;
      const auto [next, error] = std::from_chars(at, end, x);
      if (error != std::errc() || (next != end && *next != ' ')) refuse(name);
      row.push_back(x);
      at = next == end ? end : next + 1;
    }
    return row;
  }

  std::vector<double> row(const std::string& name, std::size_t multiple) const {
    std::vector<double> row = this->row(name);
    if (row.size() % multiple != 0) refuse(name);
    return row;
  }

  double number(const std::string& name) const {
    const std::vector<double> row = this->row(name);
    if (row.size() != 1) refuse(name);
    return row.front();
  }

  std::uint64_t whole(const std::string& name) const {
    const std::string& text = value_of(fields_, name, path_);
    std::uint64_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size()) refuse(name);
    return value;
  }

  Vec3 vector(const std::string& name) const {
    const std::vector<double> row = this->row(name);
    if (row.size() != 3) refuse(name);
    return {row[0], row[1], row[2]};
  }

  [[noreturn]] void refuse(const std::string& name) const {
    throw FileError(path_.string() + ": its " + name + " cannot be read");
  }

 private:
  const Fields& fields_;
  const fs::path& path_;
};

void need(bool condition, const char* message) {
  if (!condition) throw ArgumentError(message);
}

bool is_range(double least, double most) { return 0.0 <= least && least <= most && std::isfinite(most); }

}  // namespace

void validate(const Recipe& r) {
  const auto positive = [](double x) { return x > 0.0 && std::isfinite(x); };
  need(r.sampling.cone_rad >= 0.0 && r.sampling.cone_rad <= 0.5 * std::numbers::pi,
       "cone_rad: must be from 0 to pi/2");
  need(is_range(r.sampling.least_speed_m_s, r.sampling.most_speed_m_s),
       "speed_m_s: needs 0 <= least <= most");
  need(is_range(r.sampling.least_spin_rad_s, r.sampling.most_spin_rad_s),
       "spin_rad_s: needs 0 <= least <= most");
  need(positive(r.physics.hearing.merge_gap_s), "merge_gap_s: must be finite and above 0");
  need(positive(r.physics.hearing.audible_speed_m_s), "audible_speed_m_s: must be finite and above 0");
  need(positive(r.until_s), "until_s: must be finite and above 0");
}

Body settled(const Body& body) {
  constexpr int kMostTurns = 8;  // a point that is almost within the hull of others may go at the second
  Body now = body;
  for (int turn = 0; turn < kMostTurns; ++turn) {
    Body next = Body::make(now.definition());
    if (shape_fields(next.definition()) == shape_fields(now.definition())) return next;
    now = std::move(next);
  }
  throw ArgumentError("body: its hull changes whenever it is computed again; leave out points close to it");
}

Fields to_fields(const Body& body, const Recipe& r) {
  const Fields shape = shape_fields(body.definition()), material = material_fields(body.material());
  const SimulationOptions& s = r.physics.simulation;
  const HearingOptions& h = r.physics.hearing;
  Fields fields{{kName, escaped(body.name())}};
  fields.insert(fields.end(), shape.begin(), shape.end());
  fields.emplace_back("body_hash", hash_of(shape));
  fields.insert(fields.end(), material.begin(), material.end());
  fields.emplace_back("material_hash", hash_of(material));
  const Fields others{{"seed", text_of(r.seed)},
                      {"events", h.events == Events::contact ? "contact" : "audible"},
                      {"audible_speed_m_s", text_of(h.audible_speed_m_s)},
                      {"merge_gap_s", text_of(h.merge_gap_s)},
                      {"margin", text_of(r.physics.margin)},
                      {"cone_rad", text_of(r.sampling.cone_rad)},
                      {"least_speed_m_s", text_of(r.sampling.least_speed_m_s)},
                      {"most_speed_m_s", text_of(r.sampling.most_speed_m_s)},
                      {"least_spin_rad_s", text_of(r.sampling.least_spin_rad_s)},
                      {"most_spin_rad_s", text_of(r.sampling.most_spin_rad_s)},
                      {"until_s", text_of(r.until_s)},
                      {"gravity_m_s2", row_of(s.gravity_m_s2)},
                      {"step_s", text_of(s.step_s)},
                      {"micro_speed_m_s", text_of(s.micro_speed_m_s)},
                      {"rest_speed_m_s", text_of(s.rest_speed_m_s)},
                      {"rest_duration_s", text_of(s.rest_duration_s)},
                      {"max_impacts", text_of(static_cast<std::uint64_t>(s.max_impacts))},
                      {"engine", "event " + hex(engine_sum())}};
  fields.insert(fields.end(), others.begin(), others.end());
  return fields;
}

Body body_from(const Fields& fields, const fs::path& path) {
  const Reader read(fields, path);
  Body::Definition d;
  d.name = unescaped(value_of(fields, kName, path));
  const std::vector<double> vertices = read.row("vertices_m", 3), rings = read.row("rings_m", 7);
  for (std::size_t i = 0; i < vertices.size(); i += 3)
    d.vertices_m.emplace_back(vertices[i], vertices[i + 1], vertices[i + 2]);
  for (std::size_t i = 0; i < rings.size(); i += 7) {
    const double* r = &rings[i];
    d.rings_m.push_back({{r[0], r[1], r[2]}, {r[3], r[4], r[5]}, r[6]});
  }
  d.radius_m = read.number("radius_m");
  d.mass_kg = read.number("mass_kg");
  d.centre_of_mass_m = read.vector("centre_of_mass_m");
  const std::vector<double> inertia = read.row("inertia_kg_m2");
  if (inertia.size() != 9) read.refuse("inertia_kg_m2");
  d.inertia_kg_m2 = Eigen::Map<const Mat3>(inertia.data());
  d.material = {read.number("restitution"), read.number("friction"), read.number("rolling_friction_m"),
                read.number("spin_friction_m")};
  try {
    Body body = Body::make(std::move(d));
    if (hash_of(shape_fields(body.definition())) != value_of(fields, "body_hash", path))
      read.refuse("body_hash");
    return body;
  } catch (const ArgumentError& error) {
    throw FileError(path.string() + ": its body cannot be made: " + error.what());
  }
}

Recipe recipe_from(const Fields& fields, const fs::path& path) {
  const Reader read(fields, path);
  Recipe r;
  HearingOptions& h = r.physics.hearing;
  const std::string& events = value_of(fields, "events", path);
  if (events != "contact" && events != "audible") read.refuse("events");
  h.events = events == "contact" ? Events::contact : Events::audible;
  h.audible_speed_m_s = read.number("audible_speed_m_s");
  h.merge_gap_s = read.number("merge_gap_s");
  r.physics.margin = read.number("margin");
  r.seed = read.whole("seed");
  r.sampling = {read.number("cone_rad"), read.number("least_speed_m_s"), read.number("most_speed_m_s"),
                read.number("least_spin_rad_s"), read.number("most_spin_rad_s")};
  r.until_s = read.number("until_s");
  SimulationOptions& s = r.physics.simulation;
  s.gravity_m_s2 = read.vector("gravity_m_s2");
  s.step_s = read.number("step_s");
  s.micro_speed_m_s = read.number("micro_speed_m_s");
  s.rest_speed_m_s = read.number("rest_speed_m_s");
  s.rest_duration_s = read.number("rest_duration_s");
  s.max_impacts = static_cast<int>(read.whole("max_impacts"));
  try {
    validate(r);
  } catch (const ArgumentError& error) {
    throw FileError(path.string() + ": " + error.what());
  }
  return r;
}

const std::string& value_of(const Fields& fields, const std::string& name, const fs::path& path) {
  const auto at = std::ranges::find(fields, name, &Fields::value_type::first);
  if (at == fields.end()) throw FileError(path.string() + ": does not say " + name);
  return at->second;
}

std::string difference(const Fields& a, const Fields& b) {
  for (const auto& [name, value] : a) {
    if (name == kName) continue;
    const auto at = std::ranges::find(b, name, &Fields::value_type::first);
    if (at == b.end() || at->second != value) return name;
  }
  return a.size() == b.size() ? "" : b.back().first;
}

std::string difference_text(const std::string& name, const Fields& theirs, const Fields& ours,
                            const fs::path& path) {
  constexpr std::size_t kMostShown = 60;
  const auto shown = [&](const Fields& fields) {
    const auto at = std::ranges::find(fields, name, &Fields::value_type::first);
    return at == fields.end() ? std::string("nothing") : at->second;
  };
  const std::string its = shown(theirs), given = shown(ours);
  if (its.size() > kMostShown || given.size() > kMostShown)
    return name + ": " + path.string() + " is of another body";
  return name + ": " + path.string() + " has " + its + ", not " + given;
}

std::uint64_t engine_sum() {
  static const std::uint64_t sum = [] {
    // A slab, which bounces, tips and slides, and a coin, which also rolls.
    Body::Definition slab;
    for (int i = 0; i < 8; ++i)
      slab.vertices_m.push_back(Vec3(i & 1 ? 0.01 : -0.01, i & 2 ? 0.007 : -0.007, i & 4 ? 0.004 : -0.004));
    slab.radius_m = 5e-4;
    slab.mass_kg = 0.01;
    slab.inertia_kg_m2 = Vec3(2.2e-7, 3.9e-7, 5e-7).asDiagonal();
    Body::Definition coin = slab;
    coin.vertices_m.clear();
    coin.rings_m = {{{0, 0, 1e-3}, kUp, 0.012}, {{0, 0, -1e-3}, kUp, 0.012}};
    Checksum all;
    for (const Body::Definition& definition : {slab, coin}) {
      const NodeColumns nodes = harvest(Body::make(definition), {}, {}, 0, 0, 8, 3.0);
      NodeColumns::each(
          nodes, [&](const auto& column, int, const char*) { all.add(std::as_bytes(std::span(column))); });
    }
    return all.value();
  }();
  return sum;
}

}  // namespace ifa
