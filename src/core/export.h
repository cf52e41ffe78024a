// Marks what the shared libraries export.
#pragma once

// Everything else is hidden. A program may be compiled with flags that contract or reorder floating
// point operations, and may contain its own copies of our inline functions. Hiding ours keeps the
// linker from replacing them with those copies, so results stay exact. Private headers use the mark
// for what our CUDA library needs from the core.
#define DCM_EXPORT __attribute__((visibility("default")))
