/* The brake that an FMU starts with if its resources are lost; a source export writes its own. */
#define LJ_VALUES {0}
