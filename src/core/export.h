// What leaves the shared libraries.
#pragma once

// Everything else stays inside: a program whose own flags contract or reorder floating point, and
// which makes a copy of an inline function of ours, does not change the one that verdicts come
// from. What headers that are not installed mark so is for our CUDA library alone.
#define DCM_EXPORT __attribute__((visibility("default")))
