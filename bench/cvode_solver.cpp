// SUNDIALS CVODE: backward differentiation with its own root finding. Present where the library is.
#include "bench/solver.hpp"

#if defined(AFFERENT_HAS_SUNDIALS)

#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>

#include <cstdlib>

namespace afferent::bench {
namespace {

struct Problem {
    double v_r, e_k, v_th, a, drive;
};

int derivative(realtype, N_Vector x, N_Vector change, void* data) {
    const auto& p = *static_cast<Problem*>(data);
    const double* at = N_VGetArrayPointer(x);
    double* to = N_VGetArrayPointer(change);
    to[0] = p.v_r - at[0] + p.drive - at[1] * (at[0] - p.e_k);
    to[1] = -at[1] / p.a;
    return 0;
}

int jacobian(realtype, N_Vector x, N_Vector, SUNMatrix j, void* data, N_Vector, N_Vector, N_Vector) {
    const auto& p = *static_cast<Problem*>(data);
    const double* at = N_VGetArrayPointer(x);
    SM_ELEMENT_D(j, 0, 0) = -1 - at[1];
    SM_ELEMENT_D(j, 0, 1) = -(at[0] - p.e_k);
    SM_ELEMENT_D(j, 1, 0) = 0;
    SM_ELEMENT_D(j, 1, 1) = -1 / p.a;
    return 0;
}

int threshold(realtype, N_Vector x, realtype* over, void* data) {
    over[0] = N_VGetArrayPointer(x)[0] - static_cast<Problem*>(data)->v_th;
    return 0;
}

void silent(int, const char*, const char*, char*, void*) {}

class CvodeSolver final : public Solver {
  public:
    explicit CvodeSolver(double tolerance) : tolerance_(tolerance) {}

    void run(const Workload& workload, Trains& trains) override {
        for (std::size_t i = 0; i < workload.neurons; ++i) run_one(workload, i, trains[i]);
    }

  private:
    // What CVODE needs, freed in reverse.
    struct Memory {
        Memory(Problem& problem, double v, double tolerance, double most_steps) {
            SUNContext_Create(nullptr, &context);
            x = N_VNew_Serial(2, context);
            N_VGetArrayPointer(x)[0] = v;
            N_VGetArrayPointer(x)[1] = 0;
            solver = CVodeCreate(CV_BDF, context);
            CVodeSetErrHandlerFn(solver, silent, nullptr);
            CVodeInit(solver, derivative, 0, x);
            CVodeSStolerances(solver, tolerance, tolerance);
            matrix = SUNDenseMatrix(2, 2, context);
            linear = SUNLinSol_Dense(x, matrix, context);
            CVodeSetLinearSolver(solver, linear, matrix);
            CVodeSetJacFn(solver, jacobian);
            CVodeSetUserData(solver, &problem);
            CVodeSetMaxNumSteps(solver, static_cast<long>(most_steps));
            CVodeRootInit(solver, 1, threshold);
            int rising = 1;
            CVodeSetRootDirection(solver, &rising);
            CVodeSetNoInactiveRootWarn(solver);
        }
        Memory(const Memory&) = delete;
        ~Memory() {
            CVodeFree(&solver);
            SUNLinSolFree(linear);
            SUNMatDestroy(matrix);
            N_VDestroy(x);
            SUNContext_Free(&context);
        }
        SUNContext context{};
        N_Vector x{};
        void* solver{};
        SUNMatrix matrix{};
        SUNLinearSolver linear{};
    };

    void run_one(const Workload& workload, std::size_t neuron, Train& train) const {
        const LifParameters& p = workload.of(neuron);
        if (p.refractory_ms > 0) throw Unserved("has no refractory period");
        const double tau_ns = p.tau_m_ms * 1e6;
        Problem problem{p.v_r_mv, p.e_k_mv, p.v_th_mv, p.tau_g_ms / p.tau_m_ms, 0};
        Memory memory(problem, p.v_r_mv, tolerance_, workload.most_steps);
        double* x = N_VGetArrayPointer(memory.x);
        for (std::size_t row = 0; row < workload.rows(); ++row) {
            problem.drive = workload.drive_mv(row, neuron);
            const double end = Interval(workload.end(row) - workload.times[row]).count() / tau_ns;
            double now = 0;
            CVodeReInit(memory.solver, 0, memory.x);
            CVodeSetStopTime(memory.solver, end);
            while (now < end && train.size() < workload.max_spikes) {
                const int outcome = CVode(memory.solver, end, memory.x, &now, CV_NORMAL);
                if (outcome < 0) throw Unserved(name_of(outcome));
                if (outcome != CV_ROOT_RETURN) break;
                train.push_back({workload.times[row], Interval(now * tau_ns)});
                x[0] = p.v_r_mv;
                x[1] += p.delta_g;
                CVodeReInit(memory.solver, now, memory.x);
                CVodeSetStopTime(memory.solver, end);
            }
        }
    }

    static std::string name_of(int outcome) {
        char* name = CVodeGetReturnFlagName(outcome);
        std::string text = name;
        std::free(name);
        return text;
    }

    double tolerance_;
};

}  // namespace

std::vector<std::string> cvode_solver_names() { return {"cvode"}; }

std::unique_ptr<Solver> make_cvode_solver(const SolverSpec& spec) {
    if (spec.name != "cvode") return nullptr;
    return std::make_unique<CvodeSolver>(spec.setting > 0 ? spec.setting : 1e-6);
}

}  // namespace afferent::bench

#else

namespace afferent::bench {

std::vector<std::string> cvode_solver_names() { return {}; }
std::unique_ptr<Solver> make_cvode_solver(const SolverSpec&) { return nullptr; }

}  // namespace afferent::bench

#endif
