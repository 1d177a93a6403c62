/* Functions of FMI 3.0 that the FMU of exchange3.c does not have; an importer may expect the names. */
#define ABSENT(name) int name(void) { return 3; }
void *fmi3InstantiateCoSimulation(void) { return 0; }
void *fmi3InstantiateScheduledExecution(void) { return 0; }
ABSENT(fmi3ActivateModelPartition) ABSENT(fmi3DoStep) ABSENT(fmi3EnterConfigurationMode) ABSENT(fmi3EnterStepMode)
ABSENT(fmi3EvaluateDiscreteStates) ABSENT(fmi3ExitConfigurationMode) ABSENT(fmi3GetAdjointDerivative) ABSENT(fmi3GetBinary)
ABSENT(fmi3GetClock) ABSENT(fmi3GetInt16) ABSENT(fmi3GetInt64) ABSENT(fmi3GetInt8) ABSENT(fmi3GetIntervalDecimal)
ABSENT(fmi3GetIntervalFraction) ABSENT(fmi3GetNumberOfVariableDependencies) ABSENT(fmi3GetOutputDerivatives)
ABSENT(fmi3GetShiftDecimal) ABSENT(fmi3GetShiftFraction) ABSENT(fmi3GetString) ABSENT(fmi3GetUInt16) ABSENT(fmi3GetUInt32)
ABSENT(fmi3GetUInt64) ABSENT(fmi3GetUInt8) ABSENT(fmi3GetVariableDependencies) ABSENT(fmi3SetBinary) ABSENT(fmi3SetClock)
ABSENT(fmi3SetDebugLogging) ABSENT(fmi3SetInt16) ABSENT(fmi3SetInt32) ABSENT(fmi3SetInt64) ABSENT(fmi3SetInt8)
ABSENT(fmi3SetIntervalDecimal) ABSENT(fmi3SetIntervalFraction) ABSENT(fmi3SetShiftDecimal) ABSENT(fmi3SetShiftFraction)
ABSENT(fmi3SetString) ABSENT(fmi3SetUInt16) ABSENT(fmi3SetUInt32) ABSENT(fmi3SetUInt64) ABSENT(fmi3SetUInt8)
