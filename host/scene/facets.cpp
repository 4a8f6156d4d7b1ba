#include "host/scene/facets.hpp"

#include <libqhull_r/libqhull_r.h>

#include <cstdio>
#include <memory>

namespace lockstep {

std::vector<std::array<u32, 3>> facets_by_qhull(const std::vector<Vector3>& points) {
  std::vector<double> coordinates;
  for (const Vector3& p : points) coordinates.insert(coordinates.end(), p.begin(), p.end());
  std::vector<std::array<u32, 3>> triangles;

  // what qhull has to say about points that make no hull is said by the caller, in one line
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> silence(std::fopen("/dev/null", "w"), &std::fclose);
  if (!silence) return triangles;
  qhT state;
  qh_zero(&state, silence.get());
  char options[] = "qhull Qt Pp";  // Qt: triangles; Pp: no advice about precision
  const int failed = qh_new_qhull(&state, 3, static_cast<int>(points.size()), coordinates.data(), False, options,
                                  silence.get(), silence.get());
  if (failed == 0) {
    qhT* const qh = &state;
    facetT* facet;
    FORALLfacets {
      std::array<u32, 3> triangle = {};
      vertexT *vertex, **vertexp;
      unsigned corners = 0;
      FOREACHvertex_(facet->vertices) {
        if (corners < 3) triangle[corners] = static_cast<u32>(qh_pointid(qh, vertex->point));
        ++corners;
      }
      if (corners == 3) triangles.push_back(triangle);
    }
  }
  qh_freeqhull(&state, !qh_ALL);
  int current, total;
  qh_memfreeshort(&state, &current, &total);
  return triangles;
}

}  // namespace lockstep
