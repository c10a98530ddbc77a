#if defined(__x86_64__)
#define IFA_LANES_NAMESPACE lanes_sse2
#define IFA_LANES_WIDTH 2
#include "ifa/rigid/lanes/kernels.inl"

const ifa::lanes::Kernels ifa::lanes::kSse2Kernels{"sse2",
                                                   2,
                                                   &ifa::lanes_sse2::separation_speed,
                                                   &ifa::lanes_sse2::fly,
                                                   &ifa::lanes_sse2::resolve,
                                                   &ifa::lanes_sse2::step};

#endif  // __x86_64__
