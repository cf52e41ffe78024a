#include <cub/emu_cub.h>
