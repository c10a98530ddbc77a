#if defined(__x86_64__)
#define IFA_LANES_NAMESPACE lanes_avx512
#define IFA_LANES_WIDTH 8
#include "ifa/rigid/lanes/kernels.inl"

const ifa::lanes::Kernels ifa::lanes::kAvx512Kernels{"avx512",
                                                     8,
                                                     &ifa::lanes_avx512::separation_speed,
                                                     &ifa::lanes_avx512::fly,
                                                     &ifa::lanes_avx512::resolve,
                                                     &ifa::lanes_avx512::step};

#endif  // __x86_64__
