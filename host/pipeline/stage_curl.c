/* Curl: the size of the cells that makes the field nearly integrable. */
#include "curl.h"
#include "memory.h"
#include "stage.h"
#include "user_order.h"
#include <stdio.h>

static bool wanted(const pc_convert_options *options) { return options->curl_correction; }
