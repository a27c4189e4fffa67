#include "status.h"

int pc_status_exit_code(pc_status status) {
    switch (status) {
    case PC_OK:
        return 0;
    case PC_E_USAGE:
        return 2;
    case PC_E_IO:
    case PC_E_FORMAT:
        return 3;
    case PC_E_MESH:
        return 4;
    case PC_E_NOCONV:
        return 5;
    case PC_E_DEVICE:
        return 6;
    case PC_E_NOMEM:
        return 7;
    case PC_E_INTERRUPT:
        return 75;
    case PC_E_BUG:
        break;
    }
    return 1;
}

const char *pc_status_name(pc_status status) {
    switch (status) {
    case PC_OK:
        return "ok";
    case PC_E_NOMEM:
        return "out of memory";
    case PC_E_IO:
        return "input/output error";
    case PC_E_FORMAT:
        return "malformed file";
    case PC_E_MESH:
        return "unsuitable mesh";
    case PC_E_DEVICE:
        return "device error";
    case PC_E_NOCONV:
        return "no convergence";
    case PC_E_INTERRUPT:
        return "interrupted";
    case PC_E_USAGE:
        return "usage error";
    case PC_E_BUG:
        break;
    }
    return "internal error";
}
