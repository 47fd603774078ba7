/* One brake for a page in a browser; no part of the exported kernel. Apache License 2.0. */

#include "layerjam.c"

#define LJ_INFINITY (1.0 / 0.0)
#define lj_enclosure lj_strip /* the same structure again */
#include "stop_formulas.h"
#undef lj_enclosure
#define WEB(name) __attribute__((export_name(#name))) name

enum { HALVINGS = 100 };

/* The page writes the brake, and reads the end of a stop and the state after a move. */
static struct {
    lj_brake brake;
    lj_end end;
    lj_state state;
} page;

void *WEB(numbers)(void) { return &page; }

uint32_t WEB(flags)(void) { return page.state.flags; }

void WEB(start)(lj_real vacuum) { lj_start(&page.state, vacuum); }

lj_real WEB(move)(lj_real elongation, lj_real vacuum)
{
    return lj_move(&page.brake, &page.state, elongation, vacuum, 0);
}

static lj_real friction_at(lj_real vacuum)
{
    static const lj_state at_rest;
    return setting_of(&page.brake, &at_rest, vacuum, 0).c;
}

static lj_strip strip_at(lj_real vacuum)
{
    lj_enclosure e = enclosure_at(&page.brake, vacuum);
    return (lj_strip){e.stiffness, e.friction, e.reach, e.root, e.saturation};
}

/* Force [N] of the sliding brake at a slip [m] and a vacuum [Pa]. */
lj_real WEB(force_at)(lj_real slip, lj_real vacuum)
{
    lj_strip strip = strip_at(vacuum);
    return friction_at(vacuum) * lj_max(page.brake.overlap - slip, 0) +
           lj_first_loading(slip, &strip);
}

/* Stop a mass [kg] that arrives with a speed [m/s]. */
void WEB(stop)(lj_real mass, lj_real speed, lj_real vacuum, lj_real gravity, lj_real travel)
{
    lj_strip strip = strip_at(vacuum);
    lj_case drop = lj_make_setup(mass, speed, friction_at(vacuum), page.brake.overlap, &strip,
                                 page.brake.stiffness, gravity);
    lj_bracket bracket = lj_bracket_root(&drop, travel);
    lj_real low = bracket.low, high = bracket.high, middle;
    int i;
    for (i = 0; i < HALVINGS; i++) {
        middle = (low + high) / 2;
        if (lj_quartic_value(&bracket.energy, middle) > 0)
            low = middle;
        else
            high = middle;
    }
    high = lj_polish_root(&bracket.energy, high, lj_quartic_slope(&bracket.energy, high));
    page.end = lj_make_stop(&drop, &bracket, high);
}
