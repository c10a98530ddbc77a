// How error messages write numbers and name marks.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdio>
#include <string>

namespace ifa {

inline std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

// "0.52 s": at least two decimals, at most six.
inline std::string seconds(double time_s) {
  if (!(std::abs(time_s) < 1e9)) return number(time_s) + " s";
  char text[32];
  std::snprintf(text, sizeof text, "%.6f", time_s);
  std::string digits = text;
  for (int spare = 4; spare > 0 && digits.back() == '0'; --spare) digits.pop_back();
  return digits + " s";
}

// Two digits, no exponent for what people meet.
inline std::string brief(double value) {
  if (value == 0.0 || !(std::abs(value) < 1e12)) return number(value);
  const double step = std::pow(10.0, std::floor(std::log10(std::abs(value))) - 1.0);
  char text[32];
  std::snprintf(text, sizeof text, "%.12g", std::round(value / step) * step);
  return text;
}

// "1.3 mJ": two digits and a prefix.
inline std::string measure(double value, const char* unit) {
  constexpr struct {
    double size;
    const char* prefix;
  } kPrefixes[] = {{1e3, "k"}, {1.0, ""}, {1e-3, "m"}, {1e-6, "u"}};
  for (const auto& [size, prefix] : kPrefixes)
    if (value >= 0.995 * size) return brief(value / size) + " " + prefix + unit;
  return brief(value) + " " + unit;
}

// "mark 3 (0.52 s)" for index 2: users count from 1.
inline std::string mark_name(std::size_t index, double time_s) {
  return "mark " + std::to_string(index + 1) + " (" + seconds(time_s) + ")";
}

}  // namespace ifa
