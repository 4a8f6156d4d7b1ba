// Sorts the pairs in contact into the cells in which they are solved (cpu_reference/solver_cell.hpp): a counting sort,
// pairs in the order of the list within a cell.
#pragma once

#include <algorithm>

#include "cpu_reference/pair_contacts.hpp"
#include "cpu_reference/solver_cell.hpp"

namespace lockstep::reference {

/// A pair is named by its first contact. The free end of the list is filled with NONE.
template <class real>
void partition_contacts(Buffers<real>& b, const StepParams<real>& params) {
  std::fill(b.cell_starts.begin(), b.cell_starts.end(), 0u);
  std::fill(b.cell_pairs.begin(), b.cell_pairs.end(), NONE);
  const u32 contacts = b.counters[COUNTER_CONTACTS];
  std::vector<u32> cells(contacts, NONE);
  for (u32 i = 0; i < contacts; ++i) {
    if (pair_contact_count(b, i) > 0) cells[i] = cell_of_pair(b, params, b.contacts[i]);
    if (cells[i] != NONE) ++b.cell_starts[cells[i] + 1];
  }
  for (std::size_t k = 1; k < b.cell_starts.size(); ++k) b.cell_starts[k] += b.cell_starts[k - 1];
  std::vector<u32> next = b.cell_starts;
  for (u32 i = 0; i < contacts; ++i)
    if (cells[i] != NONE) b.cell_pairs[next[cells[i]]++] = i;
}

}  // namespace lockstep::reference
