/* Printed by layerjam/interop/fmi_variables.py. Apache License 2.0. */

#define LJ_TOKEN "{bf1d7650-b2cf-eb99-ec30-5acc1dd62b92}"

/* value references */
#define LJ_TIME 0u
#define LJ_ELONGATION 1u
#define LJ_VELOCITY 2u
#define LJ_VACUUM 3u
#define LJ_FORCE 10u
#define LJ_SLIP 11u
#define LJ_STIFFNESS 12u
#define LJ_WORK 13u
#define LJ_HEAT 14u
#define LJ_STORED 15u
#define LJ_TURNING 30u
#define LJ_FIRST_INPUT 1u
#define LJ_INPUTS 3
#define LJ_FIRST_OUTPUT 10u
#define LJ_OUTPUTS 6
#define LJ_FIRST_FLAG 20u
#define LJ_FLAGS 5
#define LJ_FIRST_PARAMETER 100u
#define LJ_PARAMETERS 17

/* places among the parameters */
#define LJ_SHEETS_COUNT 0
#define LJ_SHEETS_WIDTH 1
#define LJ_SHEETS_THICKNESS 2
#define LJ_SHEETS_OVERLAP 3
#define LJ_SHEETS_FREE_LEFT 4
#define LJ_SHEETS_FREE_RIGHT 5
#define LJ_FILM_MODULUS 6
#define LJ_FILM_KINETIC 7
#define LJ_FILM_FRICTION_ON_SILICONE 8
#define LJ_ENCLOSURE_WALL 9
#define LJ_ENCLOSURE_MODULUS 10
#define LJ_SCALE_FACTOR 11
#define LJ_STIFFNESS_MEASURED 12
#define LJ_PRESSURE_EXPONENT 13
#define LJ_TEST_PRESSURE 14
#define LJ_VACUUM_SHARE 15
#define LJ_ROPE_STIFFNESS 16

static const char *const lj_names[LJ_FIRST_PARAMETER] = {
    [0] = "time",
    [1] = "elongation",
    [2] = "velocity",
    [3] = "vacuum",
    [10] = "force",
    [11] = "slip",
    [12] = "stiffness",
    [13] = "work",
    [14] = "heat",
    [15] = "stored",
    [20] = "slack",
    [21] = "separated",
    [22] = "closed",
    [23] = "snapped",
    [24] = "forgotten",
    [30] = "turning",
};

typedef struct {
    const char *name;
    double least, most;
    int whole, optional;
} lj_variable;

static const lj_variable lj_parameters[LJ_PARAMETERS] = {
    {"sheets.count", 2, 10000, 1, 0},
    {"sheets.width", 0.001, 0.5, 0, 0},
    {"sheets.thickness", 1e-06, 0.01, 0, 0},
    {"sheets.overlap", 0.001, 5, 0, 0},
    {"sheets.free_left", 0.0001, 5, 0, 0},
    {"sheets.free_right", 0.0001, 5, 0, 0},
    {"film.modulus", 1000000.0, 1000000000000.0, 0, 0},
    {"film.kinetic", 0.0001, 5, 0, 0},
    {"film.friction_on_silicone", 0.0001, 5, 0, 0},
    {"enclosure.wall", 1e-05, 0.05, 0, 0},
    {"enclosure.modulus", 1000.0, 1000000000.0, 0, 0},
    {"scale_factor", 0.001, 100, 0, 0},
    {"stiffness_measured", 100, 1000000000.0, 0, 1},
    {"pressure_exponent", -0.9, 2, 0, 1},
    {"test_pressure", 1, 10000000.0, 0, 1},
    {"vacuum_share", 0.01, 1, 0, 0},
    {"rope.stiffness", 1, 1000000000.0, 0, 1},
};
