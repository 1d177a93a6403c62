/* Functions of FMI 2.0 for co-simulation that the FMU of fmi2.c does not have; an importer may expect the names. */
#define ABSENT(name) int name(void) { return 3; }
ABSENT(fmi2GetRealOutputDerivatives) ABSENT(fmi2CancelStep) ABSENT(fmi2GetIntegerStatus) ABSENT(fmi2GetStringStatus)
