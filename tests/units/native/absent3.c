/* Functions of FMI 3.0 that the FMU of fmi3.c does not have; an importer may expect the names. */
#define ABSENT(name) int name(void) { return 3; }
void *fmi3InstantiateModelExchange(void) { return 0; }
void *fmi3InstantiateScheduledExecution(void) { return 0; }
ABSENT(fmi3GetClock) ABSENT(fmi3SetClock)
ABSENT(fmi3GetNumberOfVariableDependencies) ABSENT(fmi3GetVariableDependencies) ABSENT(fmi3GetAdjointDerivative)
ABSENT(fmi3GetIntervalDecimal) ABSENT(fmi3GetIntervalFraction) ABSENT(fmi3GetShiftDecimal) ABSENT(fmi3GetShiftFraction)
ABSENT(fmi3SetIntervalDecimal) ABSENT(fmi3SetIntervalFraction) ABSENT(fmi3SetShiftDecimal) ABSENT(fmi3SetShiftFraction)
ABSENT(fmi3EvaluateDiscreteStates) ABSENT(fmi3EnterContinuousTimeMode) ABSENT(fmi3CompletedIntegratorStep) ABSENT(fmi3SetTime)
ABSENT(fmi3SetContinuousStates) ABSENT(fmi3GetContinuousStateDerivatives) ABSENT(fmi3GetEventIndicators)
ABSENT(fmi3GetContinuousStates) ABSENT(fmi3GetNominalsOfContinuousStates) ABSENT(fmi3GetNumberOfEventIndicators)
ABSENT(fmi3GetNumberOfContinuousStates) ABSENT(fmi3GetOutputDerivatives) ABSENT(fmi3ActivateModelPartition)
