!> Dummy derivatives of Mattsson and Soderlind: the constraints and both their derivatives hold as algebraic equations, and in turn
!! the derivatives of as many coordinates and velocities are no derivatives any more but unknowns, the dummies.
!!
!! Which velocities are dummies the pivots of A decide, and those of positions go with them; the others, B^T v of
!! `taut_constrained_complement`, are integrated. At each evaluation phi = 0 is solved for the dependent coordinates with the
!! independent ones held, A v = b' for the dependent velocities, and the equations of motion with A vdot = b'' for all
!! accelerations and the multipliers, which Eq. (14b) gives. All three levels hold, without a projection: what is integrated
!! stays as it is. Where the dummies no longer are determined by the others, others are chosen, and the switch is told. The
!! state is {x; v; w} all the same: what is integrated of the dummies is never used, and replaced by what follows from the
!! others.
!!
!! The source chooses by structure first and pivots within; here pivots do both, so that redundant rows are no obstacle.
!! Coordinates that are not integrals of velocities, such as quaternions, are held along the independent velocities.
!!
!! Source: S.E. Mattsson, G. Soderlind, Index reduction in differential-algebraic equations using dummy derivatives, SIAM J. Sci.
!! Comput. 14 (1993) 677-692, reference [25] of the paper.
module taut_constrained_method_dummy_derivatives
   use taut_kinds, only: wp
   use taut_constrained_method_minimal_coordinates, only: minimal_coordinates_t
   use taut_constrained_yardstick, only: relative_violation
   use taut_error, only: error_t, to_text
   use taut_ode_system, only: rhs_no_projection, rhs_ok
   implicit none (type, external)
   private
   public :: dummy_derivatives_t

   !> Round-offs of the largest coordinate that move nothing.
   real(wp), parameter :: round_off = 4.0_wp*epsilon(1.0_wp)

   !> The method `dummy-derivatives`.
   type, extends(minimal_coordinates_t) :: dummy_derivatives_t
      private
      !> Displacement of coordinates: (n); what A times it shall be: (c); none: (n).
      real(wp), allocatable :: d(:), missing(:), held(:)
      !> Whether the dependent coordinates were not found.
      logical :: lost = .false.
   contains
      procedure :: set_up
      procedure :: find_positions
      procedure :: accelerate
      procedure :: filter_error
      procedure :: multipliers
      procedure :: own_failure
      procedure :: own_remark
   end type dummy_derivatives_t

contains

   !> As `minimal-coordinates` by partitioning, with all levels kept.
   subroutine set_up(self, error)
      !> The formulation.
      class(dummy_derivatives_t), intent(inout) :: self
      !> A system that is too large.
      type(error_t), allocatable, intent(inout) :: error

      call self%minimal_coordinates_t%set_up(error)
      if (allocated(error)) return
      self%basis = .false.
      self%keeps = .false.
      self%projects_stages = .true.
      self%replaces = .true.
      self%rhs_projects = .true.
      call self%mass%init_reduced(self%model, self%options, self%projector, same_place=.true.)
      allocate (self%d(self%model%n), self%held(self%model%n), self%missing(self%model%c), source=0.0_wp)
   end subroutine set_up

   !> Solves phi = 0 for the dependent coordinates by Newton's iteration, with B^T dx = 0.
   subroutine find_positions(self, projects, info)
      !> The formulation, with the state in place.
      class(dummy_derivatives_t), intent(inout) :: self
      !> Not asked: they always are.
      logical, intent(in) :: projects
      !> One of the `rhs_` constants.
      integer, intent(out) :: info
      integer :: iteration
      real(wp) :: largest, scale

      info = rhs_ok
      self%lost = .false.
      associate (model => self%model, at => self%at, projector => self%projector)
         call model%normalize(at%x)
         do iteration = 0, self%options%max_iterations
            if (model%n_phi == 0) return
            call model%constraint(at, self%phi)
            largest = maxval(abs(self%phi))
            if (.not. largest <= huge(1.0_wp)) exit
            if (iteration == 0) projector%newton%phi_raw = largest
            scale = maxval(abs(at%x))
            if (projector%newton%yardstick%measure(self%phi, at%x) <= self%options%projection_tolerance) return
            if (iteration == self%options%max_iterations) exit
            projector%newton%iterations = projector%newton%iterations + 1
            call projector%linear%evaluate(model, at)
            call projector%linear%factorize(model, at, info, relative_violation(self%phi, projector%linear%a, at%x))
            if (info == rhs_ok) call self%fit_complement(info)
            if (info /= rhs_ok) return
            self%missing(:) = 0.0_wp
            self%missing(:model%n_phi) = -self%phi
            self%d(:) = 0.0_wp
            call projector%meet(self%missing, self%d)
            call self%complement%restore(self%held, self%d)
            call model%displace(self%d, at%x)
            call model%normalize(at%x)
            if (maxval(abs(self%d)) <= round_off*scale) return
         end do
      end associate
      self%lost = .true.
      info = rhs_no_projection
      associate (unused => projects)
      end associate
   end subroutine find_positions

   !> The accelerations and multipliers that meet the equations of motion and A vdot = b''.
   subroutine accelerate(self, vdot, info)
      !> The formulation, with the state, A, M and b'' in place.
      class(dummy_derivatives_t), intent(inout) :: self
      !> The accelerations: (n).
      real(wp), intent(inout), contiguous :: vdot(:)
      !> One of the `rhs_` constants.
      integer, intent(out) :: info

      call self%mass%reduce(self%projector, info)
      if (info /= rhs_ok) return
      call self%mass%accelerate(self%projector, self%force, vdot)
      call self%mass%correct_acceleration(self%projector, self%b_second, vdot, self%lambda)
   end subroutine accelerate

   !> Leaves of the local error what it is in the variables that are integrated.
   subroutine filter_error(self, error)
      !> The formulation.
      class(dummy_derivatives_t), intent(inout) :: self
      !> Estimate of the local error: (size).
      real(wp), intent(inout), contiguous :: error(:)
      integer :: last_v, n_x

      n_x = self%model%n_x
      last_v = n_x + self%model%n
      call self%model%v_of_x_rate(self%at, error(:n_x), self%d)
      if (self%model%n_phi > 0) call self%complement%tangential(self%d)
      call self%model%x_rate(self%at, self%d, error(:n_x))
      call self%complement%tangential(error(n_x + 1:last_v))
   end subroutine filter_error

   !> lambda of the last evaluation.
   subroutine multipliers(self, lambda)
      !> The formulation, as `rhs` left it.
      class(dummy_derivatives_t), intent(inout) :: self
      !> Of least norm: (c).
      real(wp), intent(inout), contiguous :: lambda(:)

      lambda(:) = self%lambda
      call self%mass%least_norm(self%projector, lambda)
   end subroutine multipliers

   !> Whether the dependent coordinates are what the last failure was about.
   subroutine own_failure(self, text)
      !> The formulation.
      class(dummy_derivatives_t), intent(in) :: self
      !> One line, may be empty.
      character(:), allocatable, intent(out) :: text

      text = ''
      if (self%lost) text = 'the dependent coordinates were not found in '//to_text(self%options%max_iterations)// &
                            ' iterations with the independent ones held'
   end subroutine own_failure

   !> How often other variables became dummies.
   subroutine own_remark(self, text)
      !> The formulation, behind a run.
      class(dummy_derivatives_t), intent(in) :: self
      !> One line without commas, may be empty.
      character(:), allocatable, intent(out) :: text

      text = ''
      if (self%switches > 0) text = 'dummies switched '//to_text(self%switches)//' times from t = '// &
                                    to_text(self%first_switch)//' s on'
   end subroutine own_remark

end module taut_constrained_method_dummy_derivatives
