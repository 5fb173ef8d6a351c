!> Forces that depend on the reactions of the constraints, such as friction: the multipliers that are consistent with them.
!!
!! With f + g(lambda) in the place of f, Eq. (14b) is an equation for lambda,
!!
!!     lambda = T(lambda) = M~ (A M^-1 (f + g(lambda)) - b''),
!!
!! which is begun at the multipliers of the frictionless problem, T with g = 0. Broyden's iteration begins as the substitution
!! lambda := T(lambda), which is all there is to do where g does not act along the constraints, and learns from its own steps where
!! it does.
!!
!! Source: C.G. Broyden, A class of methods for solving nonlinear simultaneous equations, Math. Comput. 19 (1965) 577-593, the first
!! of its methods.
module taut_constrained_reactions
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use taut_kinds, only: wp
   use taut_constrained_mass, only: mass_t
   use taut_constrained_projection, only: projector_t
   use taut_constrained_system, only: mechanical_system_t, state_t
   use taut_ode_system, only: rhs_ok, rhs_retry
   implicit none (type, external)
   private
   public :: reactions_t, power_of_reactions, inconsistent_reactions

   !> What is said of them.
   character(*), parameter :: inconsistent_reactions = 'no reactions are consistent with the forces that depend on them: '// &
                                                       'friction that jams'

   !> Multipliers are consistent up to this part of the largest; after so many iterations, where S is badly conditioned, up to more.
   real(wp), parameter :: tolerance = 1.0e-12_wp, lax = 1.0e-9_wp
   integer, parameter :: patient = 15
   !> So much of the forces, with `tolerance`, is round-off of the multipliers.
   real(wp), parameter :: round_off = 1.0e-2_wp
   !> More iterations than so many mean that there are none, or that they are not unique: friction that jams.
   integer, parameter :: most = 50
   !> A step that changes the residual by less than this part of what it was made for changes nothing but for round-off.
   real(wp), parameter :: no_change = 1.0e-10_wp

   !> The iteration and its workspace.
   type :: reactions_t
      !> Iterations in all.
      integer :: iterations = 0
      !> Whether the last one has found none.
      logical, private :: failed = .false.
      !> Forces, and the accelerations that they give: (n).
      real(wp), allocatable, private :: f(:), a(:)
      !> lambda, what is left of lambda - T(lambda), and that before; a step, and what of it the inverse makes: (c).
      real(wp), allocatable, private :: lambda(:), r(:), r_before(:), d(:), u(:), wr(:)
      !> Approximate inverse of the derivative of lambda - T(lambda): (c, c).
      real(wp), allocatable, private :: inverse(:, :)
   contains
      procedure :: init
      procedure :: add
      procedure :: explain
   end type reactions_t

contains

   !> Makes room, if there are such forces.
   subroutine init(self, model)
      !> The iteration.
      class(reactions_t), intent(inout) :: self
      !> The system.
      class(mechanical_system_t), intent(in) :: model

      if (.not. model%reactive) return
      allocate (self%f(model%n), self%a(model%n), self%lambda(model%c), self%r(model%c), self%r_before(model%c), &
                self%d(model%c), self%u(model%c), self%wr(model%c), self%inverse(model%c, model%c), source=0.0_wp)
   end subroutine init

   !> f := f + g(lambda), with lambda consistent.
   subroutine add(self, model, at, mass, projector, b_second, force, info)
      !> The iteration.
      class(reactions_t), intent(inout) :: self
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Its state, on the constraints.
      type(state_t), intent(in) :: at
      !> M and M~, reduced there.
      type(mass_t), intent(inout) :: mass
      !> The projector, with A there.
      type(projector_t), intent(inout) :: projector
      !> b'': (c).
      real(wp), intent(in), contiguous :: b_second(:)
      !> Forces that do not depend on lambda; all of them on return: (n).
      real(wp), intent(inout), contiguous :: force(:)
      !> `rhs_ok`, or `rhs_retry` where no multipliers are found.
      integer, intent(out) :: info
      real(wp) :: left, size_of_it
      integer :: c, i, iteration
      logical :: jammed

      info = rhs_ok
      self%failed = .false.
      c = model%c
      self%f(:) = force
      call answer(self%lambda)
      self%inverse(:, :) = 0.0_wp
      do i = 1, c
         self%inverse(i, i) = 1.0_wp
      end do
      do iteration = 1, most
         self%iterations = self%iterations + 1
         call model%reaction_force(at, self%lambda, self%f)
         do i = 1, model%n
            self%f(i) = force(i) + self%f(i)
         end do
         call answer(self%wr)
         size_of_it = 0.0_wp
         left = 0.0_wp
         do i = 1, c
            self%r(i) = self%lambda(i) - self%wr(i)
            size_of_it = max(size_of_it, abs(self%wr(i)))
            left = max(left, abs(self%r(i)))
         end do
         if (.not. ieee_is_finite(left)) exit
         ! Where the forces balance each other, multipliers are small differences of what has their round-off.
         size_of_it = max(size_of_it, round_off*maxval(abs(self%f))/maxval(abs(projector%linear%a%values)))
         if (left <= merge(tolerance, lax, iteration <= patient)*size_of_it) then
            force(:) = self%f
            return
         end if
         if (iteration > 1) then
            call learn(self, jammed)
            if (jammed) exit
         end if
         self%d(:) = -matmul(self%inverse, self%r)
         self%lambda(:) = self%lambda + self%d
         self%r_before(:) = self%r
      end do
      self%failed = .true.
      info = rhs_retry

   contains

      !> Multipliers of the forces in `f`, of least norm where they are not unique.
      subroutine answer(lambda)
         real(wp), intent(inout), contiguous :: lambda(:)

         call mass%accelerate(projector, self%f, self%a)
         call mass%correct_acceleration(projector, b_second, self%a, lambda)
         call mass%least_norm(projector, lambda)
      end subroutine answer

   end subroutine add

   !> The inverse takes the last step d to be what the change of the residual asks for.
   pure subroutine learn(self, jammed)
      type(reactions_t), intent(inout) :: self
      !> Whether that step has changed nothing: what the constraints answer is taken back.
      logical, intent(out) :: jammed
      real(wp) :: along
      integer :: i, j

      self%u(:) = matmul(self%inverse, self%r - self%r_before)
      along = dot_product(self%d, self%u)
      jammed = abs(along) <= no_change*dot_product(self%d, self%d)
      if (jammed) return
      self%wr(:) = matmul(self%d, self%inverse)
      do j = 1, size(self%d)
         do i = 1, size(self%d)
            self%inverse(i, j) = self%inverse(i, j) + (self%d(i) - self%u(i))*self%wr(j)/along
         end do
      end do
   end subroutine learn

   !> Power of the forces that depend on the multipliers [W].
   function power_of_reactions(model, at, lambda) result(power)
      !> The system, reactive.
      class(mechanical_system_t), intent(in) :: model
      !> The state.
      type(state_t), intent(in) :: at
      !> Multipliers: (c).
      real(wp), intent(in) :: lambda(:)
      !> g(lambda) v.
      real(wp) :: power
      real(wp) :: value(model%n)

      call model%reaction_force(at, lambda, value)
      power = dot_product(value, at%v)
   end function power_of_reactions

   !> Why the last iteration failed, in words; empty if it did not.
   subroutine explain(self, text)
      !> The iteration.
      class(reactions_t), intent(in) :: self
      !> One line.
      character(:), allocatable, intent(out) :: text

      text = ''
      if (self%failed) text = inconsistent_reactions
   end subroutine explain

end module taut_constrained_reactions
