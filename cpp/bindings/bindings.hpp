// What the binding files share. Python validates nothing twice: arrays are checked here, once, and
// errors name the argument.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <chrono>
#include <condition_variable>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
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

// Runs a long call on a thread of its own without the GIL, so that Ctrl-C reaches Python meanwhile: it
// cancels the call and raises KeyboardInterrupt. `progress` may be null.
template <class Result, class Work>
Result run_interruptible(std::shared_ptr<Progress> progress, Work&& work) {
  if (!progress) progress = std::make_shared<Progress>();
  std::optional<Result> result;
  std::exception_ptr error;
  std::mutex mutex;
  std::condition_variable finished;
  bool done = false;
  std::thread worker([&] {
    try {
      result.emplace(work(progress.get()));
    } catch (...) {
      error = std::current_exception();
    }
    const std::lock_guard lock(mutex);
    done = true;
    finished.notify_one();
  });
  bool interrupted = false;
  {
    const py::gil_scoped_release release;
    for (;;) {
      {
        std::unique_lock lock(mutex);
        if (finished.wait_for(lock, std::chrono::milliseconds(30), [&] { return done; })) break;
      }
      const py::gil_scoped_acquire acquire;
      if (!interrupted && PyErr_CheckSignals() != 0) {
        interrupted = true;
        progress->cancel();
      }
    }
    worker.join();
  }
  if (interrupted) throw py::error_already_set();
  if (error) std::rethrow_exception(error);
  return std::move(*result);
}

void bind_base(py::module_& m);
void bind_sound(py::module_& m);
void bind_rigid(py::module_& m);
void bind_batch(py::module_& m);
void bind_signature(py::module_& m);
void bind_motion(py::module_& m);
void bind_solution(py::module_& m);
void bind_forward(py::module_& m);
void bind_explain(py::module_& m);
void bind_graph(py::module_& m);
void bind_verify(py::module_& m);

}  // namespace ifa::bindings
