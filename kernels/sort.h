// Sorts a list of indices in place, by one work-item.
#ifndef LOCKSTEP_SORT_H
#define LOCKSTEP_SORT_H

// Restores the heap below `root` of a list of `count`: no entry is smaller than its children.
static inline void sift_down(global u32* list, u32 root, u32 count) {
  const u32 value = list[root];
  for (u32 child = 2u * root + 1u; child < count; child = 2u * root + 1u) {
    if (child + 1u < count && list[child + 1u] > list[child]) ++child;
    if (list[child] <= value) break;
    list[root] = list[child];
    root = child;
  }
  list[root] = value;
}

// Insertion for short lists; a heap for long ones, which are as bad as all shapes in one place.
static inline void sort_ascending(global u32* list, u32 count) {
  if (count <= 32u) {
    for (u32 i = 1u; i < count; ++i) {
      const u32 value = list[i];
      u32 k = i;
      for (; k > 0u && list[k - 1u] > value; --k) list[k] = list[k - 1u];
      list[k] = value;
    }
    return;
  }
  for (u32 root = count / 2u; root > 0u; --root) sift_down(list, root - 1u, count);
  for (u32 end = count - 1u; end > 0u; --end) {
    const u32 largest = list[0];
    list[0] = list[end];
    list[end] = largest;
    sift_down(list, 0u, end);
  }
}

#endif
