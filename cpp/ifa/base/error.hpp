// Every error of ours. The bindings map each to one Python class (bindings/base.cpp).
#pragma once

#include <stdexcept>
#include <string>

namespace ifa {

// ifa.IfaError
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// A bad argument; its message names the field. ifa.IfaValueError, also a ValueError.
class ArgumentError : public Error {
 public:
  using Error::Error;
};

// A file that cannot be read or written; its message names the file. ifa.IfaFileError, also an OSError.
class FileError : public Error {
 public:
  using Error::Error;
};

// The caller asked to stop. ifa.Cancelled
class Cancelled : public Error {
 public:
  Cancelled() : Error("cancelled") {}
};

}  // namespace ifa
