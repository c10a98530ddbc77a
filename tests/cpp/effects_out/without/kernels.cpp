// The kernels of the engine with effects compiled out: the two narrow sets, which build soon.
#include "ifa/rigid/kernels.hpp"

#include <array>

namespace ifa::lanes {

std::span<const Kernels* const> available_kernels() {
#if defined(__x86_64__)
  static const std::array<const Kernels*, 2> all{&kScalarKernels, &kSse2Kernels};
#else
  static const std::array<const Kernels*, 1> all{&kScalarKernels};
#endif
  return all;
}

}  // namespace ifa::lanes
