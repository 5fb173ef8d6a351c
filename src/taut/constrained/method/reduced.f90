!> The paper's method on a smaller system with the same motion, for integrators that ask for derivatives alone.
!!
!! The state y is that of the whole system, and so is everything that is told of it: right-hand sides, projections and filters are
!! those of the smaller system, and what follows from its state is carried along. Where multipliers are asked for, the whole
!! system is evaluated.
module taut_constrained_method_reduced
   use taut_archive, only: archive_t
   use taut_kinds, only: wp
   use taut_error, only: error_t
   use taut_constrained_method, only: sample_t
   use taut_constrained_method_options, only: method_t
   use taut_constrained_method_present, only: present_t
   use taut_constrained_system, only: mechanical_system_t, state_t
   use taut_constrained_system_reducible, only: reducible_system_t, reduction_t
   use taut_ode_system, only: inside_step, rhs_ok
   implicit none (type, external)
   private
   public :: reduced_t, find_reduction

   !> The method `present`, reduced.
   type, extends(present_t) :: reduced_t
      !> The smaller system.
      class(reduction_t), allocatable :: reduction
      !> The method on it.
      type(present_t), private :: core
      !> Its state, a derivative or an error of it: (size of its y).
      real(wp), allocatable, private :: y(:), dy(:)
      !> The state of the whole system of which `y` is that of the smaller one, to the last digit: (size).
      real(wp), allocatable, private :: whole_y(:)
      !> Where the entries of its y are in y.
      integer, allocatable, private :: place(:)
   contains
      procedure :: set_up
      procedure :: begin
      procedure :: rhs
      procedure :: project
      procedure :: filter_error
      procedure :: later_corrections
      procedure :: accepted
      procedure :: sample
      procedure :: sample_reactions
      procedure :: own_failure
      procedure :: own_remark
      procedure :: recount
      procedure :: serialize_own
   end type reduced_t

contains

   !> The smaller system of a system, if it has one and the method has the same motion with it.
   subroutine find_reduction(model, method, reduction)
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> The method.
      type(method_t), intent(in) :: method
      !> The smaller system; not allocated if there is none.
      class(reduction_t), allocatable, intent(out) :: reduction

      if (.not. method%reduce .or. method%name /= 'present' .or. method%state_projection /= 'position-velocity' .or. &
          method%weight == 'given' .or. method%accept_inconsistent .or. model%reactive .or. model%n_w > 0) return
      select type (model)
      class is (reducible_system_t)
         call model%reduce(reduction)
      end select
   end subroutine find_reduction

   !> Sets up the method on both systems.
   subroutine set_up(self, error)
      !> The formulation, with its reduction.
      class(reduced_t), intent(inout) :: self
      !> A smaller system that does not fit.
      type(error_t), allocatable, intent(inout) :: error
      type(method_t) :: options

      options = self%options
      ! Where the whole system is evaluated, the smaller one has brought it onto the constraints.
      self%options%stage_projection = 'none'
      call self%present_t%set_up(error)
      self%options = options
      call self%reduction%system%check_sizes(error)
      if (allocated(error)) return
      ! The smaller one's mass matrix is the only metric that does not depend on which coordinates are left.
      options%weight = 'mass'
      call self%core%init(self%reduction%system, options, error)
      self%rhs_projects = self%core%rhs_projects
      ! It has a copy.
      deallocate (self%reduction%system)
      self%place = [self%reduction%x, self%model%n_x + self%reduction%v]
      allocate (self%y(size(self%place)), self%dy(size(self%place)), source=0.0_wp)
      allocate (self%whole_y(self%size()), source=huge(1.0_wp))
   end subroutine set_up

   !> Gets both ready for a motion.
   subroutine begin(self, at)
      !> The formulation.
      class(reduced_t), intent(inout) :: self
      !> Initial state.
      type(state_t), intent(in) :: at
      type(state_t) :: small

      call self%present_t%begin(at)
      small%t = at%t
      small%x = at%x(self%reduction%x)
      small%v = at%v(self%reduction%v)
      call self%reduction%narrow(small%x, small%v)
      allocate (small%w(0))
      call self%core%begin(small)
   end subroutine begin

   !> The derivative of the smaller system's state, and what follows from it.
   subroutine rhs(self, t, y, dydt, info)
      !> The formulation.
      class(reduced_t), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> State {x; v}: (size).
      real(wp), intent(in), contiguous :: y(:)
      !> Its derivative: (size).
      real(wp), intent(out), contiguous :: dydt(:)
      !> One of the `rhs_` constants.
      integer, intent(out) :: info

      call take_state(self, y)
      call look_where_it_looks(self)
      call self%core%rhs(t, self%y, self%dy, info)
      if (info /= rhs_ok) return
      call put_back(self, self%dy, dydt)
      associate (n_x => self%model%n_x)
         call self%reduction%widen_rate(self%core%at, dydt(:n_x), dydt(n_x + 1:))
      end associate
      self%integrand = self%core%integrand
      self%integral_counts = self%core%integral_counts
      self%projector%newton%iterations = self%core%projector%newton%iterations
   end subroutine rhs

   !> Replaces the smaller system's state by the one on the constraints, and what follows from it.
   subroutine project(self, t, y, place, stale, info)
      !> The formulation.
      class(reduced_t), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> State {x; v}, replaced: (size).
      real(wp), intent(inout), contiguous :: y(:)
      !> `inside_step`, `step_end` or `evaluated_step_end`.
      integer, intent(in) :: place
      !> Whether the derivative has to be evaluated again.
      logical, intent(out) :: stale
      !> One of the `rhs_` constants.
      integer, intent(out) :: info

      call take_state(self, y)
      call look_where_it_looks(self)
      call self%core%project(t, self%y, place, stale, info)
      self%projector%newton%iterations = self%core%projector%newton%iterations
      if (info /= rhs_ok) return
      call put_back(self, self%y, y)
      associate (n_x => self%model%n_x)
         call self%reduction%widen(self%core%at, y(:n_x), y(n_x + 1:))
      end associate
      if (self%reduction%narrows) self%whole_y(:) = y
      if (place == inside_step) return
      self%step_end%phi = self%core%step_end%phi
      self%step_end%phidot = self%core%step_end%phidot
      self%step_end%mu(:) = 0.0_wp
      self%step_end%mu(self%reduction%row) = self%core%step_end%mu
   end subroutine project

   !> Takes off the local error what `project` will take off the state; errors of what follows are those of what it follows from.
   subroutine filter_error(self, error)
      !> The formulation.
      class(reduced_t), intent(inout) :: self
      !> Estimate of the local error: (size).
      real(wp), intent(inout), contiguous :: error(:)

      call take(self, error, self%dy)
      associate (n_x => self%core%model%n_x)
         if (self%reduction%narrows) call self%reduction%narrow_change(self%core%at, self%dy(:n_x), self%dy(n_x + 1:))
      end associate
      call self%core%filter_error(self%dy)
      call put_back(self, self%dy, error)
      associate (n_x => self%model%n_x)
         call self%reduction%widen_change(self%core%at, error(:n_x), error(n_x + 1:))
      end associate
   end subroutine filter_error

   !> By how much the last projection of positions has moved them after its first correction.
   subroutine later_corrections(self, d, bends)
      !> The formulation.
      class(reduced_t), intent(in) :: self
      !> Displacement, if there is any: (n_x).
      real(wp), intent(inout), contiguous :: d(:)
      !> Whether there is.
      logical, intent(out) :: bends
      real(wp) :: small(self%core%model%n_x), unmoved(self%model%n)

      call self%core%later_corrections(small, bends)
      if (.not. bends) return
      d(self%reduction%x) = small
      unmoved(:) = 0.0_wp
      call self%reduction%widen_change(self%core%at, d, unmoved)
   end subroutine later_corrections

   !> Looks at the rank.
   subroutine accepted(self, t, y, replaced)
      !> The formulation.
      class(reduced_t), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> State {x; v}: (size).
      real(wp), intent(inout), contiguous :: y(:)
      !> False: it stays.
      logical, intent(out) :: replaced

      call take_state(self, y)
      call look_where_it_looks(self)
      call self%core%accepted(t, self%y, replaced)
   end subroutine accepted

   !> What there is to know of a state of the whole system.
   subroutine sample(self, t, y, s, info)
      !> The formulation.
      class(reduced_t), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> State: (size).
      real(wp), intent(in), contiguous :: y(:)
      !> What there is to know; its arrays are allocated if they are not.
      type(sample_t), intent(inout) :: s
      !> One of the `rhs_` constants.
      integer, intent(out) :: info

      call let_rank_go(self)
      call self%present_t%sample(t, y, s, info)
   end subroutine sample

   !> Its multipliers, and what it computes besides.
   subroutine sample_reactions(self, t, y, outputs, s, info)
      !> The formulation.
      class(reduced_t), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> State: (size).
      real(wp), intent(in), contiguous :: y(:)
      !> Whether what the system computes besides is wanted.
      logical, intent(in) :: outputs
      !> `lambda` is set, and `outputs`; its arrays are allocated if they are not.
      type(sample_t), intent(inout) :: s
      !> One of the `rhs_` constants.
      integer, intent(out) :: info

      call let_rank_go(self)
      call self%present_t%sample_reactions(t, y, outputs, s, info)
   end subroutine sample_reactions

   !> The rank of the smaller system is looked at where steps end. Where that is not full, the whole system decides anew wherever it
   !! is evaluated.
   subroutine let_rank_go(self)
      type(reduced_t), intent(inout) :: self

      associate (keeper => self%core%projector%linear%keeper)
         if (keeper%holds .and. all(keeper%kept)) return
      end associate
      call self%projector%linear%release()
   end subroutine let_rank_go

   !> Why the smaller system could not be evaluated or projected.
   subroutine own_failure(self, text)
      !> The formulation.
      class(reduced_t), intent(in) :: self
      !> One line without commas, may be empty.
      character(:), allocatable, intent(out) :: text

      call self%core%failure(text)
   end subroutine own_failure

   !> What happened to the smaller system on the way.
   subroutine own_remark(self, text)
      !> The formulation.
      class(reduced_t), intent(in) :: self
      !> One line without commas, may be empty.
      character(:), allocatable, intent(out) :: text

      call self%core%remark(text)
   end subroutine own_remark

   !> Tells the iterations of the projection, or takes their count back.
   subroutine recount(self, count, back)
      !> The formulation.
      class(reduced_t), intent(inout) :: self
      !> Iterations of Eq. (17).
      integer, intent(inout) :: count
      !> Whether it is taken back; otherwise it is told.
      logical, intent(in) :: back

      call self%core%recount(count, back)
      call self%present_t%recount(count, back)
   end subroutine recount

   !> Passes through an archive what the method on the smaller system remembers.
   subroutine serialize_own(self, archive)
      !> The formulation.
      class(reduced_t), intent(inout) :: self
      !> The archive.
      type(archive_t), intent(inout) :: archive

      call self%core%serialize(archive)
   end subroutine serialize_own

   !> What the integrator says to the whole system.
   pure subroutine look_where_it_looks(self)
      type(reduced_t), intent(inout) :: self

      self%core%t_low = self%t_low
      self%core%t_high = self%t_high
      self%core%has_integral = self%has_integral
   end subroutine look_where_it_looks

   !> The state of the smaller system, which is known of a state that it has left: what it is from there on has another last digit.
   pure subroutine take_state(self, y)
      type(reduced_t), intent(inout) :: self
      real(wp), intent(in), contiguous :: y(:)
      integer :: i

      if (.not. self%reduction%narrows) then
         call take(self, y, self%y)
         return
      end if
      do i = 1, size(y)
         if (.not. abs(y(i) - self%whole_y(i)) <= 0.0_wp) exit
      end do
      if (i > size(y)) return
      self%whole_y(:) = y
      call take(self, y, self%y)
      associate (n_x => self%core%model%n_x)
         call self%reduction%narrow(self%y(:n_x), self%y(n_x + 1:))
      end associate
   end subroutine take_state

   !> The entries of the smaller system.
   pure subroutine take(self, y, small)
      type(reduced_t), intent(in) :: self
      real(wp), intent(in), contiguous :: y(:)
      real(wp), intent(inout), contiguous :: small(:)
      integer :: i

      do i = 1, size(small)
         small(i) = y(self%place(i))
      end do
   end subroutine take

   !> Puts them where they were taken from.
   pure subroutine put_back(self, small, y)
      type(reduced_t), intent(in) :: self
      real(wp), intent(in), contiguous :: small(:)
      real(wp), intent(inout), contiguous :: y(:)
      integer :: i

      do i = 1, size(small)
         y(self%place(i)) = small(i)
      end do
   end subroutine put_back

end module taut_constrained_method_reduced
