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

// "mark 3 (0.52 s)" for index 2: users count from 1.
inline std::string mark_name(std::size_t index, double time_s) {
  return "mark " + std::to_string(index + 1) + " (" + seconds(time_s) + ")";
}

}  // namespace ifa
