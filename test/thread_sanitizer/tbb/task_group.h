#pragma once

#include "on_threads.h"
