/* A core module of WebAssembly: FMI 3 as elsewhere, and what a host needs that is no C program. A function of such a host is no
   pointer, so the one function that the host may hand over, the logger, is imported. */
#include "fmi3.h"
#include "native.h"

__attribute__((import_module("host"), import_name("log")))
void host_log(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category, fmi3String message);

/* What fmi3InstantiateCoSimulation takes as logMessage for messages to the imported function. */
EXPORT fmi3LogMessageCallback host_logger(void) { return host_log; }
