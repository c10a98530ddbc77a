#include "ifa/rigid/kernels.hpp"

#include <array>

namespace ifa::lanes {

std::span<const Kernels* const> available_kernels() {
#if defined(__x86_64__)
  static const std::array<const Kernels*, 4> all{&kScalarKernels, &kSse2Kernels, &kAvx2Kernels,
                                                 &kAvx512Kernels};
  static const std::size_t runs = [] {
    __builtin_cpu_init();
    if (!__builtin_cpu_supports("avx2")) return 2;
    return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
                   __builtin_cpu_supports("avx512vl")
               ? 4
               : 3;
  }();
  return std::span(all).first(runs);
#else
  static const std::array<const Kernels*, 1> all{&kScalarKernels};
  return all;
#endif
}

}  // namespace ifa::lanes
