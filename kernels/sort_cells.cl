#pragma OPENCL FP_CONTRACT OFF
#include "common.h"
#include "grid.h"
#include "sort.h"
#include "top_level_shapes.h"
#include "types.h"

kernel void sort_cells_clear(global u32* bucket_starts, global u32* bucket_items, const StepParams params) {
  FOR_EACH(k, params.buckets + 1u) { bucket_starts[k] = 0u; }
  FOR_EACH(i, top_level_count(&params)) { bucket_items[i] = NONE; }
}

// The order of arrival in a bucket depends on the scheduling; sort_cells_order makes up for it.
kernel void sort_cells_count(global const BodyInfo* body_infos, global const ShapeInfo* shape_infos,
                             global const u32* top_level_shapes, global const Bound* bounds, global Cell* cells,
                             global u32* bucket_starts, global u32* cell_arrivals, global u32* counters,
                             const StepParams params) {
  const real size = cell_size(counters[COUNTER_MAX_EXTENT]);
  FOR_EACH(i, top_level_count(&params)) {
    const Vec3 center = make3(bounds[i].center[0], bounds[i].center[1], bounds[i].center[2]);
    const u32 body = shape_infos[TOP_LEVEL_SHAPE(i)].body;
    Cell cell = {0, 0, 0, NONE};
    if (bounds[i].extent > (real)0) {
      if (in_grid(center.x, size) && in_grid(center.y, size) && in_grid(center.z, size)) {
        cell.x = cell_of(center.x, size);
        cell.y = cell_of(center.y, size);
        cell.z = cell_of(center.z, size);
        cell.bucket = bucket_of(cell.x, row_hash(cell.y, cell.z, body_infos[body].world), params.buckets);
        cell_arrivals[i] = atomic_inc(&bucket_starts[cell.bucket]);
      } else {
        atomic_or(&counters[COUNTER_STATUS], (u32)STATUS_OUT_OF_GRID);
        atomic_max(&counters[COUNTER_BAD_BODY], NONE - body);
      }
    }
    cells[i] = cell;
  }
}

kernel void sort_cells_fill(global const Cell* cells, global const u32* bucket_starts, global const u32* cell_arrivals,
                            global u32* bucket_items, const StepParams params) {
  FOR_EACH(i, top_level_count(&params)) {
    const u32 bucket = cells[i].bucket;
    if (bucket != NONE) bucket_items[bucket_starts[bucket] + cell_arrivals[i]] = i;
  }
}

kernel void sort_cells_order(global const u32* bucket_starts, global u32* bucket_items, const StepParams params) {
  FOR_EACH(k, params.buckets) {
    const u32 start = bucket_starts[k];
    sort_ascending(bucket_items + start, bucket_starts[k + 1u] - start);
  }
}
