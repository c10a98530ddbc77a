#if defined(__x86_64__)
#define IFA_LANES_NAMESPACE lanes_avx2
#define IFA_LANES_WIDTH 4
#include "ifa/rigid/lanes/kernels.inl"

const ifa::lanes::Kernels ifa::lanes::kAvx2Kernels{"avx2",
                                                   4,
                                                   &ifa::lanes_avx2::separation_speed,
                                                   &ifa::lanes_avx2::fly,
                                                   &ifa::lanes_avx2::resolve,
                                                   &ifa::lanes_avx2::step};

#endif  // __x86_64__
