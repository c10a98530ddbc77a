#include "motions.hpp"

#include <algorithm>
#include <cmath>

namespace ifa::verify::test {
namespace {

Spinning step(const Mat3& inertia, const Spinning& s, double h) {
  const Mat3 inverse = inertia.inverse();
  const auto rate_q = [](const Quat& q, const Vec3& w) {
    return Eigen::Vector4d(0.5 * (q * Quat(0, w.x(), w.y(), w.z())).coeffs());
  };
  const auto rate_w = [&](const Vec3& w) { return Vec3(inverse * Vec3((inertia * w).cross(w))); };
  const Eigen::Vector4d q0 = s.q.coeffs();
  const Eigen::Vector4d a1 = rate_q(s.q, s.w);
  const Vec3 b1 = rate_w(s.w);
  const Vec3 w2 = s.w + 0.5 * h * b1;
  const Eigen::Vector4d a2 = rate_q(Quat(Eigen::Vector4d(q0 + 0.5 * h * a1)), w2);
  const Vec3 b2 = rate_w(w2);
  const Vec3 w3 = s.w + 0.5 * h * b2;
  const Eigen::Vector4d a3 = rate_q(Quat(Eigen::Vector4d(q0 + 0.5 * h * a2)), w3);
  const Vec3 b3 = rate_w(w3);
  const Vec3 w4 = s.w + h * b3;
  const Eigen::Vector4d a4 = rate_q(Quat(Eigen::Vector4d(q0 + h * a3)), w4);
  const Vec3 b4 = rate_w(w4);
  Spinning r = s;
  r.q = Quat(Eigen::Vector4d(q0 + h / 6.0 * (a1 + 2 * a2 + 2 * a3 + a4))).normalized();
  r.w = s.w + h / 6.0 * (b1 + 2 * b2 + 2 * b3 + b4);
  r.x = s.x + h * s.v - Vec3(0, 0, 0.5 * kG * h * h);
  r.v = s.v - Vec3(0, 0, kG * h);
  return r;
}

Spinning fly(const Mat3& inertia, Spinning s, double length) {
  const int n = std::max(1, static_cast<int>(std::ceil(length / 1e-5)));
  for (int i = 0; i < n; ++i) s = step(inertia, s, length / n);
  return s;
}

int lowest_corner(const Body& body, const Spinning& s, double* height) {
  int lowest = 0;
  *height = 1e300;
  for (std::size_t k = 0; k < body.vertices().size(); ++k) {
    const double h = s.x.z() + (s.q * body.vertices()[k]).z();
    if (h >= *height) continue;
    *height = h;
    lowest = static_cast<int>(k);
  }
  return lowest;
}

// Samples in [from, to], uniform, at most 1 ms apart, at least four inside; the first left to the caller.
int parts(double from, double to) {
  return std::max(5, static_cast<int>(std::ceil((to - from) / 1e-3 - 1e-9)));
}

}  // namespace

int Motion::first_at(double time_s) const {
  return static_cast<int>(std::lower_bound(poses.times_s.begin(), poses.times_s.end(), time_s - 1e-12) -
                          poses.times_s.begin());
}

Body ball(double radius_m) {
  Body::Definition d;
  d.vertices_m = {Vec3::Zero()};
  d.radius_m = radius_m;
  d.mass_kg = 0.005;
  d.inertia_kg_m2 = 0.4 * d.mass_kg * radius_m * radius_m * Mat3::Identity();
  return Body::make(d);
}

Body box(const Vec3& size_m) {
  Body::Definition d;
  for (int i = 0; i < 8; ++i)
    d.vertices_m.push_back(0.5 * size_m.cwiseProduct(Vec3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1)));
  d.mass_kg = 0.01;
  const Vec3 s = size_m.cwiseAbs2();
  d.inertia_kg_m2 = (d.mass_kg / 12.0 * Vec3(s.y() + s.z(), s.x() + s.z(), s.x() + s.y())).asDiagonal();
  return Body::make(d);
}

Motion bouncing_ball(const Body& body, double height_m, double restitution, int bounces, double every_s) {
  struct Piece {
    double start, end, height, speed;
  };
  std::vector<Piece> pieces;
  Motion motion;
  double speed = std::sqrt(2.0 * kG * height_m);
  double t = speed / kG;
  pieces.push_back({0.0, t, height_m, 0.0});
  for (int k = 0; k < bounces; ++k) {
    motion.impact_times_s.push_back(t);
    motion.impact_speeds_m_s.push_back(speed);
    if (k + 1 == bounces) break;
    speed *= restitution;
    pieces.push_back({t, t + 2.0 * speed / kG, 0.0, speed});
    t += 2.0 * speed / kG;
  }
  const Vec3 drift(0.3, -0.2, 0.0), spin(1.0, 2.0, -1.5);
  const auto pose = [&](const Piece& p, double time) {
    const double s = time - p.start;
    const double z = p.height + p.speed * s - 0.5 * kG * s * s;
    motion.add(time, Vec3(0, 0, z + body.radius_m()) + time * drift, rotation_exp(time * spin));
  };
  const Piece stand{t, t + 0.1, 0.0, 0.0};
  const auto stand_at = [&](double time) {
    motion.add(time, Vec3(0, 0, body.radius_m()) + t * drift, rotation_exp(t * spin));
  };
  if (every_s > 0.0) {
    for (int i = 0; i * every_s <= stand.end; ++i) {
      const double time = i * every_s;
      const auto p =
          std::find_if(pieces.begin(), pieces.end(), [&](const Piece& c) { return time <= c.end; });
      if (p == pieces.end())
        stand_at(time);
      else
        pose(*p, time);
    }
    return motion;
  }
  pose(pieces[0], 0.0);
  for (const Piece& p : pieces) {
    const int n = parts(p.start, p.end);
    for (int i = 1; i <= n; ++i) pose(p, i == n ? p.end : p.start + (p.end - p.start) * i / n);
    motion.poses.positions_m.back().z() = body.radius_m();
  }
  for (int i = 1; i <= 100; ++i) stand_at(t + 1e-3 * i);
  return motion;
}

Motion tumbling_box(const Body& body, double restitution, int impacts, double every_s) {
  return tossed_box(body, {{0, 0, 0.1}, {0.4, 0.1, -0.5}, rotation_exp({0.3, -0.4, 1.0}), {9.0, -14.0, 6.0}},
                    restitution, impacts, every_s);
}

Motion tossed_box(const Body& body, const Spinning& start, double restitution, int impacts, double every_s) {
  const Mat3& inertia = body.inertia_kg_m2();
  Spinning s = start;
  std::vector<double> starts{0.0};
  std::vector<Spinning> states{s};
  Motion motion;
  double height = 0.0;
  for (int k = 0; k <= impacts; ++k) {
    const double h = 1e-5;
    double t = starts.back();
    if (k == impacts) {
      Spinning end = s;  // ends in flight, half-way to the next contact or after 10 ms
      double length = 0.0;
      for (; length < 0.02 && (length < 1e-3 || height > 0.0); length += h) {
        end = step(inertia, end, h);
        lowest_corner(body, end, &height);
      }
      starts.push_back(t + 0.5 * length);
      break;
    }
    for (;;) {
      const Spinning next = step(inertia, s, h);
      const int corner = lowest_corner(body, next, &height);
      const double rate = next.v.z() + (next.q * next.w).cross(next.q * body.vertices()[corner]).z();
      if (height < 0.0 && rate < 0.0) break;
      s = next;
      t += h;
    }
    double low = 0.0, high = h;
    for (int i = 0; i < 60; ++i) {
      const double middle = 0.5 * (low + high);
      lowest_corner(body, step(inertia, s, middle), &height);
      (height > 0.0 ? low : high) = middle;
    }
    s = step(inertia, s, low);
    t += low;
    const int corner = lowest_corner(body, s, &height);
    const Vec3 arm = s.q * body.vertices()[corner];
    const double approach = -(s.v.z() + (s.q * s.w).cross(arm).z());
    const Vec3 lever = arm.cross(kUp);
    const Mat3 inverse = s.q.toRotationMatrix() * inertia.inverse() * s.q.toRotationMatrix().transpose();
    const double impulse =
        (1.0 + restitution) * approach / (1.0 / body.mass_kg() + lever.dot(inverse * lever));
    s.v.z() += impulse / body.mass_kg();
    s.w += s.q.conjugate() * (inverse * (impulse * lever));
    motion.impact_times_s.push_back(t);
    motion.impact_speeds_m_s.push_back(approach);
    starts.push_back(t);
    states.push_back(s);
  }
  if (every_s > 0.0) {
    std::size_t piece = 0;
    Spinning at = states[0];
    double now = 0.0;
    for (int i = 0; i * every_s <= starts.back(); ++i) {
      const double time = i * every_s;
      while (time > starts[piece + 1]) {
        ++piece;
        at = states[piece];
        now = starts[piece];
      }
      if (time > now) at = fly(inertia, at, time - now);
      now = time;
      motion.add(time, at.x, at.q);
    }
    return motion;
  }
  motion.add(0.0, states[0].x, states[0].q);
  for (std::size_t p = 0; p < states.size(); ++p) {
    const double length = starts[p + 1] - starts[p];
    const int n = parts(0.0, length);
    Spinning at = states[p];
    for (int i = 1; i <= n; ++i) {
      at = fly(inertia, at, length / n);
      motion.add(i == n ? starts[p + 1] : starts[p] + length * i / n, at.x, at.q);
    }
  }
  return motion;
}

Motion tipping_box(const Body& body) {
  // In the plane: the mass centre at distance r from the edge, phi above the horizontal, falling.
  const Vec3 half(body.vertices()[7].cwiseAbs());
  const double r = std::hypot(half.x(), half.z()), flat = std::atan2(half.z(), half.x());
  const double inertia = body.inertia_kg_m2()(1, 1) + body.mass_kg() * r * r;
  const double c = body.mass_kg() * kG * r / inertia;
  double phi = flat + 0.3, w = 0.0, t = 0.0;
  std::vector<double> times{0.0}, angles{phi};
  const auto advance = [&](double h) {  // phi'' = -c cos phi, Runge-Kutta 4
    const auto f = [&](double p) { return -c * std::cos(p); };
    const double k1 = w, l1 = f(phi), k2 = w + 0.5 * h * l1, l2 = f(phi + 0.5 * h * k1);
    const double k3 = w + 0.5 * h * l2, l3 = f(phi + 0.5 * h * k2), k4 = w + h * l3, l4 = f(phi + h * k3);
    phi += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
    w += h / 6 * (l1 + 2 * l2 + 2 * l3 + l4);
    t += h;
  };
  for (;;) {
    const double phi0 = phi, w0 = w, t0 = t;
    advance(1e-3);
    if (phi < flat) {
      double low = 0.0, high = 1e-3;
      for (int i = 0; i < 60; ++i) {
        const double middle = 0.5 * (low + high);
        phi = phi0, w = w0, t = t0;
        advance(middle);
        (phi > flat ? low : high) = middle;
      }
      times.push_back(t);
      angles.push_back(flat);
      break;
    }
    times.push_back(t);
    angles.push_back(phi);
  }
  Motion motion;
  motion.impact_times_s = {t};
  motion.impact_speeds_m_s = {-w * 2.0 * half.x()};  // of the far edge
  // Pivot at the origin, the box towards +x, tilted by phi - flat about -y.
  const auto x = [&](double p) { return Vec3(r * std::cos(p), 0, r * std::sin(p)); };
  const auto q = [&](double p) { return rotation_exp({0, flat - p, 0}); };
  const int n = static_cast<int>(std::ceil(t / 0.73e-3));
  std::size_t node = 0;
  for (int i = 0; i <= n; ++i) {
    const double time = t * i / n;
    while (node + 2 < times.size() && time > times[node + 1]) ++node;
    const double share = (time - times[node]) / (times[node + 1] - times[node]);
    motion.add(time, (1 - share) * x(angles[node]) + share * x(angles[node + 1]),
               q(angles[node]).slerp(share, q(angles[node + 1])));
  }
  for (int i = 1; i <= 80; ++i) motion.add(t + 1e-3 * i, x(flat), q(flat));
  return motion;
}

Body disk(double radius_m) {
  Body::Definition d;
  d.rings_m = {{Vec3::Zero(), kUp, radius_m}};
  d.mass_kg = 0.008;
  d.inertia_kg_m2 = (d.mass_kg * radius_m * radius_m * Vec3(0.25, 0.25, 0.5)).asDiagonal();
  return Body::make(d);
}

Motion rocking_disk(const Body& body, double rate, double least_tilt, bool slaps) {
  const double radius = body.rings()[0].radius_m, far = 0.1;  // rad, at both ends
  Motion motion;
  const auto add = [&](double t) {
    const Vec3 lean(least_tilt, rate * (slaps ? std::min(t, 0.0) : t), 0.0);
    const double tilt = lean.norm();
    motion.add(t, {0, 0, radius * std::sin(tilt)},
               tilt > 0.0 ? rotation_exp(kUp.cross(lean)) : Quat::Identity());
  };
  for (double t = -far / rate; t < 0.0;) {
    add(t);
    const double runs = std::atan2(rate * t, least_tilt) + 0.2;
    t = std::min(t + 1e-3, least_tilt > 0.0 && runs < 0.0 ? least_tilt * std::tan(runs) / rate : 0.0);
  }
  add(0.0);
  const std::vector<double> before = motion.poses.times_s;
  for (std::size_t i = before.size() - 1; !slaps && i-- > 0;) add(-before[i]);
  for (int i = 1; slaps && i <= 80; ++i) add(1e-3 * i);
  return motion;
}

Motion sliding_box(const Body& body) {
  const double z = body.vertices()[7].cwiseAbs().z(), stop = 0.2;
  Motion motion;
  for (int i = 0; i <= 300; ++i) {
    const double t = 1e-3 * i, s = std::min(t, stop);
    const double slid = 0.6 * (s - 0.5 * s * s / stop), turned = 5.0 * (s - 0.5 * s * s / stop);
    motion.add(t, {slid, 0.5 * slid, z}, rotation_exp({0, 0, turned}));
  }
  return motion;
}

MarkSet marks_of(const Motion& motion, bool rest) {
  MarkSet marks;
  marks.rest = rest;
  double previous = -1.0;
  for (std::size_t i = 0; i < motion.impact_times_s.size(); ++i) {
    if (motion.impact_speeds_m_s[i] <= 0.05) continue;
    if (motion.impact_times_s[i] - previous >= 0.010) marks.times_s.push_back(motion.impact_times_s[i]);
    previous = motion.impact_times_s[i];
  }
  return marks;
}

void retime(Motion* motion, const std::vector<double>& ratio) {
  std::vector<double> knots = motion->impact_times_s, moved = knots;
  for (std::size_t k = 1; k < knots.size(); ++k)
    moved[k] = moved[k - 1] + ratio[k] * (knots[k] - knots[k - 1]);
  for (double& t : motion->poses.times_s) {
    const auto above = std::lower_bound(knots.begin(), knots.end(), t) - knots.begin();
    if (above == 0) continue;
    const auto size = static_cast<std::ptrdiff_t>(knots.size());
    t = moved[above - 1] + (above < size ? ratio[above] : 1.0) * (t - knots[above - 1]);
  }
  motion->impact_times_s = moved;
}

}  // namespace ifa::verify::test
