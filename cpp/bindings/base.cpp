// Errors, progress, and the conversion of arrays.
#include "bindings.hpp"

#include <cstring>

namespace ifa::bindings {
namespace {

[[noreturn]] void bad_shape(const Array& array, const std::string& field, const std::string& wanted) {
  std::string shape = "(";
  for (py::ssize_t i = 0; i < array.ndim(); ++i) {
    if (i > 0) shape += ", ";
    shape += std::to_string(array.shape(i));
  }
  shape += ")";
  throw ArgumentError(field + ": needs shape " + wanted + ", got " + shape);
}

PyObject* new_exception(py::module_& m, const char* name, py::tuple bases, const char* doc) {
  const std::string qualified = std::string("ifa.") + name;
  PyObject* type = PyErr_NewExceptionWithDoc(qualified.c_str(), doc, bases.ptr(), nullptr);
  if (!type) throw py::error_already_set();
  m.add_object(name, py::handle(type));
  return type;
}

}  // namespace

std::vector<double> to_vector(const Array& array, const std::string& field) {
  if (array.ndim() != 1) bad_shape(array, field, "(n,)");
  return {array.data(), array.data() + array.size()};
}

std::vector<Vec3> to_points(const Array& array, const std::string& field) {
  if (array.ndim() != 2 || array.shape(1) != 3) bad_shape(array, field, "(n, 3)");
  std::vector<Vec3> points(array.shape(0));
  for (std::size_t i = 0; i < points.size(); ++i) points[i] = Eigen::Map<const Vec3>(array.data(i, 0));
  return points;
}

Vec3 to_vec3(const Array& array, const std::string& field) {
  if (array.ndim() != 1 || array.size() != 3) bad_shape(array, field, "(3,)");
  return Eigen::Map<const Vec3>(array.data());
}

Mat3 to_mat3(const Array& array, const std::string& field) {
  if (array.ndim() != 2 || array.shape(0) != 3 || array.shape(1) != 3) bad_shape(array, field, "(3, 3)");
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(array.data());
}

Array from_vector(const std::vector<double>& values) {
  return Array(static_cast<py::ssize_t>(values.size()), values.data());
}

Array from_points(const std::vector<Vec3>& points) {
  Array array({static_cast<py::ssize_t>(points.size()), py::ssize_t{3}});
  double* out = array.mutable_data();
  for (const Vec3& p : points) out = std::copy(p.data(), p.data() + 3, out);
  return array;
}

Array from_quaternions(const std::vector<Quat>& quaternions) {
  Array array({static_cast<py::ssize_t>(quaternions.size()), py::ssize_t{4}});
  double* out = array.mutable_data();
  for (const Quat& q : quaternions) {
    *out++ = q.w();
    out = std::copy(q.vec().data(), q.vec().data() + 3, out);
  }
  return array;
}

Array from_vec3(const Vec3& v) { return Array(3, v.data()); }

Array from_mat3(const Mat3& m) {
  const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> rows = m;
  Array array({3, 3});
  std::copy(rows.data(), rows.data() + 9, array.mutable_data());
  return array;
}

void bind_base(py::module_& m) {
  static PyObject* error = new_exception(m, "IfaError", py::make_tuple(py::handle(PyExc_Exception)),
                                         "Every error of this package is one of these.");
  static PyObject* value_error =
      new_exception(m, "IfaValueError", py::make_tuple(py::handle(error), py::handle(PyExc_ValueError)),
                    "A bad argument; the message names it.");
  static PyObject* file_error =
      new_exception(m, "IfaFileError", py::make_tuple(py::handle(error), py::handle(PyExc_OSError)),
                    "A file that cannot be read or written; the message names it.");
  static PyObject* cancelled =
      new_exception(m, "Cancelled", py::make_tuple(py::handle(error)), "The caller cancelled a long call.");
  py::register_exception_translator([](std::exception_ptr p) {
    // File names need not be UTF-8; a message must be.
    const auto raise = [](PyObject* type, const char* what) {
      const py::object text = py::reinterpret_steal<py::object>(
          PyUnicode_DecodeUTF8(what, static_cast<py::ssize_t>(std::strlen(what)), "replace"));
      PyErr_SetObject(type, text.ptr());
    };
    try {
      if (p) std::rethrow_exception(p);
    } catch (const ArgumentError& e) {
      raise(value_error, e.what());
    } catch (const FileError& e) {
      raise(file_error, e.what());
    } catch (const Cancelled& e) {
      raise(cancelled, e.what());
    } catch (const Error& e) {
      raise(error, e.what());
    }
  });

  py::class_<Progress, std::shared_ptr<Progress>>(
      m, "Progress",
      "Watches and cancels one long call. Hand it to the call, then from any other thread read\n"
      "`fraction` (0 to 1, never falls) and call `cancel()`: the call ends with ifa.Cancelled.")
      .def(py::init<>())
      .def_property_readonly("fraction", &Progress::fraction, "Share of the work done, 0 to 1.")
      .def("cancel", &Progress::cancel, "Ask the call to stop; it raises ifa.Cancelled.")
      .def_property_readonly("cancelled", &Progress::cancelled)
      .def("raise_to", &Progress::raise_to, py::arg("fraction"),
           "Say that so much is done; less than before is nothing.")
      .def(
          "part",
          [](Progress& whole, double from, double to) {
            return std::make_shared<Progress>(&whole, from, to);
          },
          py::arg("from_fraction"), py::arg("to_fraction"), py::keep_alive<0, 1>(),
          "Of a call within this one: its whole is this one's share from one fraction to another, and "
          "cancelling\n"
          "this cancels it.");
}

}  // namespace ifa::bindings
