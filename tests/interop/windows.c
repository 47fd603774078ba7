/* The smallest importer of an FMI 3.0 co-simulation for Windows: load, step, print the forces.
 * Usage: windows LIBRARY RESOURCES ELONGATION... [m] */

#include <stdio.h>
#include <stdlib.h>
#include <windows.h>

#include "fmi3FunctionTypes.h"
#include "variables.h"

static void log_(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category,
                 fmi3String message)
{
    (void)environment;
    (void)status;
    (void)category;
    printf("%s\n", message);
}

static FARPROC named(HMODULE library, const char *name)
{
    FARPROC found = GetProcAddress(library, name);
    if (!found) {
        printf("%s is missing\n", name);
        exit(1);
    }
    return found;
}

#define FIND(type, name) type##TYPE *name = (type##TYPE *)(void *)named(library, #type)

int main(int count, char **words)
{
    const fmi3ValueReference elongation = LJ_ELONGATION, vacuum = LJ_VACUUM, force = LJ_FORCE;
    const double full = 94500;
    HMODULE library = count > 3 ? LoadLibraryA(words[1]) : NULL;
    fmi3Boolean event, ended, early;
    fmi3Instance one;
    double last, given, found;
    int i;
    if (!library) {
        printf("%s does not load\n", count > 1 ? words[1] : "nothing");
        return 1;
    }
    FIND(fmi3InstantiateCoSimulation, make);
    FIND(fmi3EnterInitializationMode, enter);
    FIND(fmi3ExitInitializationMode, leave);
    FIND(fmi3SetFloat64, set);
    FIND(fmi3GetFloat64, get);
    FIND(fmi3DoStep, step);
    one = make("one", LJ_TOKEN, words[2], fmi3False, fmi3False, fmi3False, fmi3False, NULL, 0, NULL,
               log_, NULL);
    if (!one || enter(one, fmi3False, 0, 0, fmi3False, 0) != fmi3OK)
        return 1;
    if (set(one, &vacuum, 1, &full, 1) != fmi3OK || leave(one) != fmi3OK)
        return 1;
    for (i = 3; i < count; i++) {
        given = atof(words[i]);
        if (set(one, &elongation, 1, &given, 1) != fmi3OK)
            return 1;
        if (step(one, i, 1, fmi3True, &event, &ended, &early, &last) != fmi3OK)
            return 1;
        if (get(one, &force, 1, &found, 1) != fmi3OK)
            return 1;
        printf("%.17g\n", found);
    }
    return 0;
}
