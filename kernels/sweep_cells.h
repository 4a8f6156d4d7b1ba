// The order of the solves where pairs are solved in cells: the phases of a sweep are those of the cells, then the
// colours and the overflow blocks of pairs that are in none. A phase consists of units that may be solved at once, a
// cell or a single block; the blocks of a unit follow one another.
#ifndef LOCKSTEP_SWEEP_CELLS_H
#define LOCKSTEP_SWEEP_CELLS_H

#include "solver_cell.h"
#include "sweep_contacts.h"

typedef struct CellPhase {
  u32 begin, end;  // units
  bool in_cells;   // else they are blocks
} CellPhase;

static inline u32 cell_phases(global const u32* counters) { return CELL_PHASES + contact_phases(counters); }

// Nothing where there is no such phase, the step is aborted, or the sweep skipped.
static inline CellPhase cell_phase(u32 phase, const StepParams* params, global const u32* color_starts,
                                   global const u32* counters) {
  CellPhase units = {0u, 0u, phase < CELL_PHASES};
  if (SWEEP_SKIPPED(counters) || phase >= cell_phases(counters)) return units;
  const u32 cells = cells_in_phase(params);
  units.begin = units.in_cells ? phase * cells : phase_begin(phase - CELL_PHASES, color_starts, counters);
  units.end = units.in_cells ? units.begin + cells : phase_end(phase - CELL_PHASES, color_starts, counters);
  return units;
}

// Who solves a unit: on a CPU device one work-item, which needs no barrier and has the bodies in its cache; elsewhere
// PACK of them, whose work-group meets behind each block.
#if LANES > 1
#define CELL_TEAM_SIZE 1u
#define CELL_TEAM_BARRIER
#else
#define CELL_TEAM_SIZE min((u32)get_local_size(0), PACK)
#define CELL_TEAM_BARRIER barrier(CLK_GLOBAL_MEM_FENCE)
#endif
#define CELL_TEAMS ((u32)get_local_size(0) / CELL_TEAM_SIZE)

typedef struct CellTeam {
  u32 first, last;      // blocks of its unit, none where it has no unit
  u32 rounds;           // that its work-group makes
  u32 member, members;  // of the items of a block it takes every members-th
} CellTeam;

static inline u32 cell_unit_block(u32 unit, CellPhase phase, global const u32* cell_blocks) {
  return phase.in_cells ? cell_blocks[unit] : unit;
}

// The team of this work-item, where the work-group takes the units from `base` on.
static inline CellTeam cell_team(u32 base, CellPhase phase, global const u32* cell_blocks) {
  const u32 item = (u32)get_local_id(0), unit = base + item / CELL_TEAM_SIZE;
  CellTeam team = {0u, 0u, 0u, item % CELL_TEAM_SIZE, CELL_TEAM_SIZE};
  if (item / CELL_TEAM_SIZE < CELL_TEAMS && unit < phase.end) {
    team.first = cell_unit_block(unit, phase, cell_blocks);
    team.last = cell_unit_block(unit + 1u, phase, cell_blocks);
  }
  team.rounds = team.last - team.first;
#if LANES == 1
  for (u32 k = base; k < base + CELL_TEAMS && k < phase.end; ++k)
    team.rounds =
        max(team.rounds, cell_unit_block(k + 1u, phase, cell_blocks) - cell_unit_block(k, phase, cell_blocks));
#endif
  return team;
}

// The items of a block that a team has in a round.
static inline u32 cell_team_items(CellTeam team, u32 round) {
  return team.first + round < team.last ? ITEMS_PER_BLOCK : 0u;
}

// The units of a phase, shared out among work-groups. Loops make at least one round, as all with a barrier.
static inline void sweep_cell_phase(const u32 purpose, CellPhase phase, u32 group, u32 groups,
                                    global const u32* cell_blocks, const ContactStream* s) {
  u32 base = phase.begin + group * CELL_TEAMS;
  do {
    const CellTeam team = cell_team(base, phase, cell_blocks);
    u32 round = 0u;
    do {
      for (u32 item = team.member; item < cell_team_items(team, round); item += team.members)
        solve_phase_item(purpose, team.first + round, item, s);
      CELL_TEAM_BARRIER;
    } while (++round < team.rounds);
    base += groups * CELL_TEAMS;
  } while (base < phase.end);
}

// One work-group: the phases from `first_phase` on.
static inline void sweep_cell_tail(const u32 purpose, u32 first_phase, const StepParams* params,
                                   global const u32* color_starts, global const u32* cell_blocks,
                                   const ContactStream* s, global const u32* counters) {
  u32 phase = min(first_phase, CELL_PHASES + counters[COUNTER_COLORS]);
  do {
    sweep_cell_phase(purpose, cell_phase(phase, params, color_starts, counters), 0u, 1u, cell_blocks, s);
    barrier(CLK_GLOBAL_MEM_FENCE);
  } while (++phase < cell_phases(counters));
}

#endif
