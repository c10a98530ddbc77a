#define IFA_LANES_NAMESPACE lanes_scalar
#define IFA_LANES_WIDTH 1
#include "ifa/rigid/lanes/kernels.inl"

const ifa::lanes::Kernels ifa::lanes::kScalarKernels{"scalar",
                                                     1,
                                                     &ifa::lanes_scalar::separation_speed,
                                                     &ifa::lanes_scalar::fly,
                                                     &ifa::lanes_scalar::resolve,
                                                     &ifa::lanes_scalar::step};
