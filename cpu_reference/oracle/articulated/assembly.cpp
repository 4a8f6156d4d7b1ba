#include "cpu_reference/oracle/articulated/assembly.hpp"

#include <algorithm>

#include "cpu_reference/oracle/dense.hpp"

namespace lockstep::oracle::articulated {

namespace {

bool moves(const System& system, std::size_t body) { return body != world && system.bodies[body].mass > 0; }

void keep_once(std::vector<std::size_t>& handles) {
  std::ranges::sort(handles);
  handles.erase(std::unique(handles.begin(), handles.end()), handles.end());
}

Assembly kept(const Assembly& from, const std::vector<std::size_t>& handles) {
  Assembly to = {handles, MatrixXd(6 * handles.size(), 6 * handles.size()), VectorXd(6 * handles.size()), from.rounds};
  for (std::size_t i = 0; i < handles.size(); ++i) {
    const Index row = from.first_row(handles[i]);
    to.free.segment<6>(6 * Index(i)) = from.free.segment<6>(row);
    for (std::size_t j = 0; j < handles.size(); ++j)
      to.inverse_inertia.block<6, 6>(6 * Index(i), 6 * Index(j)) =
          from.inverse_inertia.block<6, 6>(row, from.first_row(handles[j]));
  }
  return to;
}

Assembly beside(const Assembly& a, const Assembly& b) {
  Assembly both = {a.handles, {}, VectorXd(a.free.size() + b.free.size()), std::max(a.rounds, b.rounds)};
  both.handles.insert(both.handles.end(), b.handles.begin(), b.handles.end());
  both.inverse_inertia = MatrixXd::Zero(both.free.size(), both.free.size());
  both.inverse_inertia.topLeftCorner(a.free.size(), a.free.size()) = a.inverse_inertia;
  both.inverse_inertia.bottomRightCorner(b.free.size(), b.free.size()) = b.inverse_inertia;
  both.free.head(a.free.size()) = a.free;
  both.free.tail(b.free.size()) = b.free;
  return both;
}

class Division {
 public:
  Division(const Kinematics& at, const LinkVectors& wrench, const LinkVectors& product)
      : at_(at), tree_(at.tree()), wrench_(wrench), product_(product) {}

  // `links`: connected, parents before children. `handles`: bodies, once each.
  Assembly assemble(const std::vector<std::size_t>& links, const std::vector<std::size_t>& handles) const {
    if (links.size() == 1) return kept(single(links[0]), handles);
    const std::size_t cut = best_cut(links);
    std::vector<std::size_t> near, far;  // far: the cut link and what hangs from it
    std::vector<bool> below(tree_.size(), false);
    for (const std::size_t i : links) {
      const std::size_t parent = tree_.link(i).parent;
      below[i] = i == cut || (parent != no_link && below[parent]);
      (below[i] ? far : near).push_back(i);
    }
    const auto needed = [&](std::size_t at_cut, bool is_far) {
      std::vector<std::size_t> bodies = {tree_.link(at_cut).body};
      for (const std::size_t body : handles) {
        if (below[tree_.link_of(body)] == is_far) bodies.push_back(body);
      }
      keep_once(bodies);
      return bodies;
    };
    const Assembly far_side = assemble(far, needed(cut, true));
    const Assembly near_side = assemble(near, needed(tree_.link(cut).parent, false));
    Assembly whole = beside(near_side, far_side);
    ++whole.rounds;
    join(cut, whole);
    return kept(whole, handles);
  }

 private:
  // The link whose joint to its parent parts the links most evenly.
  std::size_t best_cut(const std::vector<std::size_t>& links) const {
    std::vector<std::size_t> count(tree_.size(), 0);
    std::size_t best = links[1], least = links.size();
    for (std::size_t k = links.size(); k-- > 1;) {
      const std::size_t i = links[k], size = ++count[i], larger = std::max(size, links.size() - size);
      if (larger < least) best = i, least = larger;
      count[tree_.link(i).parent] += size;
    }
    return best;
  }

  Assembly single(std::size_t i) const {
    const Link& link = tree_.link(i);
    Matrix6 inverse = Matrix6::Zero();
    inverse.topLeftCorner<3, 3>().diagonal().setConstant(1 / tree_.system().bodies[link.body].mass);
    inverse.bottomRightCorner<3, 3>() = at_.link(i).inertia.inverse();
    Assembly one = {{link.body}, inverse, inverse * wrench_[i]};
    if (link.parent == no_link && link.joint != no_link) join(i, one);  // to what does not move
    return one;
  }

  // Locks what the joint of a link to its parent locks.
  void join(std::size_t i, Assembly& a) const {
    const Link& link = tree_.link(i);
    const std::vector<Row> locked = rows_of(tree_.joint_of(link), at_.configuration());
    if (locked.empty()) return;
    const MatrixXd g = rows_on(a, locked);
    VectorXd off = g * a.free;
    for (std::size_t k = 0; k < locked.size() && !product_.empty(); ++k)
      off[Index(k)] -= (link.child_is_b ? locked[k].on_b : locked[k].on_a).dot(product_[i]);
    const MatrixXd k = a.inverse_inertia * g.transpose(), w = g * k;
    a.free -= k * solve_by_lu(w, off);
    a.inverse_inertia -= product(k, solve_by_lu(w, MatrixXd(k.transpose())));
  }

  const Kinematics& at_;
  const Tree& tree_;
  const LinkVectors &wrench_, &product_;
};

}  // namespace

Index Assembly::first_row(std::size_t body) const {
  return 6 * Index(std::ranges::find(handles, body) - handles.begin());
}

MatrixXd rows_on(const Assembly& assembly, const std::vector<Row>& rows) {
  MatrixXd g = MatrixXd::Zero(Index(rows.size()), assembly.free.size());
  const auto add = [&](Index row, std::size_t body, const Vector6& on) {
    const Index first = assembly.first_row(body);
    if (body != world && first < g.cols()) g.row(row).segment<6>(first) += on.transpose();
  };
  for (std::size_t i = 0; i < rows.size(); ++i) {
    add(Index(i), rows[i].body_a, rows[i].on_a);
    add(Index(i), rows[i].body_b, rows[i].on_b);
  }
  return g;
}

Assembly assembled(const Kinematics& at, std::size_t number, const LinkVectors& wrench, const LinkVectors& product,
                   const std::vector<std::size_t>& handles) {
  std::vector<std::size_t> links, bodies = handles;
  for (std::size_t i = at.tree().starts()[number]; i < at.tree().starts()[number + 1]; ++i) links.push_back(i);
  keep_once(bodies);
  return Division(at, wrench, product).assemble(links, bodies);
}

Assembly assembled(const Step& step, std::vector<std::size_t> handles) {
  const Tree& tree = step.tree();
  const LinkVectors none(tree.size(), Vector6::Zero());
  keep_once(handles);
  std::erase_if(handles, [&](std::size_t body) { return !moves(tree.system(), body); });
  Assembly all;
  for (std::size_t t = 0; t + 1 < tree.starts().size(); ++t) {
    std::vector<std::size_t> mine;
    for (const std::size_t body : handles) {
      const std::size_t link = tree.link_of(body);
      if (link != no_link && tree.link(link).tree == t) mine.push_back(body);
    }
    if (!mine.empty()) all = beside(all, assembled(step.kinematics(), t, none, {}, mine));
  }
  for (const std::size_t body : handles) {
    if (tree.link_of(body) != no_link) continue;
    const LoneBody& lone = step.given().lone[body];
    Matrix6 inverse = Matrix6::Zero();
    inverse.topLeftCorner<3, 3>().diagonal().setConstant(lone.inverse_mass);
    inverse.bottomRightCorner<3, 3>() = lone.inverse_inertia;
    all = beside(all, {{body}, inverse, Vector6::Zero()});
  }
  all = kept(all, handles);
  for (std::size_t i = 0; i < handles.size(); ++i) all.free.segment<6>(6 * Index(i)) = step.twists()[handles[i]];
  return all;
}

AssembledProblem assembled_problem(const Step& step, const Demand& demand, const std::vector<std::size_t>& more) {
  AssembledProblem result;
  result.problem = reduced_rows(step, demand);
  ReducedProblem& p = result.problem;
  std::vector<std::size_t> handles = more;
  for (const Row& row : p.rows) handles.insert(handles.end(), {row.body_a, row.body_b});
  for (const Row& row : step.bilateral_rows()) handles.insert(handles.end(), {row.body_a, row.body_b});
  Assembly& a = result.assembly;
  a = assembled(step, handles);
  result.rows = rows_on(a, p.rows);
  if (!step.bilateral_rows().empty()) {
    const MatrixXd g = rows_on(a, step.bilateral_rows()), k = a.inverse_inertia * g.transpose();
    p.coupling = product(MatrixXd(k.transpose()), MatrixXd(result.rows.transpose()));
    a.inverse_inertia += product(k, step.bilateral().response(k.transpose()));
  }
  result.responses = product(a.inverse_inertia, result.rows.transpose());
  const MatrixXd w = product(result.rows, result.responses);
  p.w = MatrixXd(0.5 * (w + w.transpose())).sparseView();
  return result;
}

}  // namespace lockstep::oracle::articulated
