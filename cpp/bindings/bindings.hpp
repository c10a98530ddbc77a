// What the binding files share. Python validates nothing twice: arrays are checked here, once, and
// errors name the argument.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <memory>
#include <string>
#include <vector>

#include "ifa/base/error.hpp"
#include "ifa/base/linear_algebra.hpp"
#include "ifa/base/progress.hpp"

namespace ifa::bindings {

namespace py = pybind11;

// C-contiguous float64, converted where needed.
using Array = py::array_t<double, py::array::c_style | py::array::forcecast>;

std::vector<double> to_vector(const Array& array, const std::string& field);  // (n,)
std::vector<Vec3> to_points(const Array& array, const std::string& field);    // (n, 3)
Vec3 to_vec3(const Array& array, const std::string& field);                   // (3,)
Mat3 to_mat3(const Array& array, const std::string& field);                   // (3, 3)
Array from_vector(const std::vector<double>& values);
Array from_points(const std::vector<Vec3>& points);
Array from_quaternions(const std::vector<Quat>& quaternions);  // (n, 4), wxyz
Array from_vec3(const Vec3& v);
Array from_mat3(const Mat3& m);

void bind_base(py::module_& m);
void bind_sound(py::module_& m);
void bind_rigid(py::module_& m);
void bind_signature(py::module_& m);
void bind_motion(py::module_& m);
void bind_forward(py::module_& m);
void bind_verify(py::module_& m);

}  // namespace ifa::bindings
