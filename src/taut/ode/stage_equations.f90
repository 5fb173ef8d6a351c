!> The equations of an implicit stage of y' = f(t, y): ydot - f(t, y) = 0.
module taut_ode_stage_equations
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use taut_kinds, only: wp
   use taut_linalg_lapack, only: dgetrf, dgetrs, zgetrf, zgetrs
   use taut_ode_system, only: ode_system_t, rhs_cannot, rhs_ok, rhs_retry, stage_equations_t
   implicit none (type, external)
   private
   public :: plain_equations_t

   !> Step of the differences relative to the size of what is varied.
   real(wp), parameter :: difference = sqrt(epsilon(1.0_wp))

   !> ydot = f(t, y), with the factorizations that the system offers, or with its full Jacobian by differences.
   type, extends(stage_equations_t) :: plain_equations_t
      !> Whether the Jacobian is that of differences, for the system has no factorizations.
      logical, private :: own = .false.
      real(wp), allocatable, private :: jacobian(:, :), real_lu(:, :), real_r(:), f(:), near(:), f_near(:)
      complex(wp), allocatable, private :: complex_lu(:, :)
      integer, allocatable, private :: real_pivot(:), complex_pivot(:)
   contains
      procedure :: init
      procedure :: start
      procedure :: residual
      procedure :: find_integrand
      procedure :: linearize
      procedure :: factorize
      procedure :: solve
      procedure :: multiply
      procedure :: round_off
   end type plain_equations_t

contains

   !> Allocates the workspace.
   subroutine init(self, n)
      !> The equations.
      class(plain_equations_t), intent(out) :: self
      !> Number of entries of the state.
      integer, intent(in) :: n

      self%n = n
      allocate (self%jacobian(n, n), self%real_lu(n, n), self%real_r(n), self%f(n), self%near(n), self%f_near(n), source=0.0_wp)
      allocate (self%complex_lu(n, n), source=(0.0_wp, 0.0_wp))
      allocate (self%real_pivot(n), self%complex_pivot(n), source=0)
   end subroutine init

   !> The derivative of the state.
   subroutine start(self, ode, t, y, first, ydot, z, info)
      !> The equations.
      class(plain_equations_t), intent(inout) :: self
      !> The system.
      class(ode_system_t), intent(inout) :: ode
      !> Time [s].
      real(wp), intent(in) :: t
      !> State: (n).
      real(wp), intent(in), contiguous :: y(:)
      !> Of no account.
      logical, intent(in) :: first
      !> Its derivative: (n).
      real(wp), intent(out), contiguous :: ydot(:)
      !> There are none: (0).
      real(wp), intent(inout), contiguous :: z(:)
      !> One of the `rhs_` constants.
      integer, intent(out) :: info

      self%evaluations = self%evaluations + 1
      call ode%rhs(t, y, ydot, info)
      if (info == rhs_ok .and. .not. all(ieee_is_finite(ydot))) info = rhs_retry
      associate (unused_first => first, unused_z => z)
      end associate
   end subroutine start

   !> ydot - f(t, y).
   subroutine residual(self, ode, t, y, ydot, z, r, info)
      !> The equations.
      class(plain_equations_t), intent(inout) :: self
      !> The system.
      class(ode_system_t), intent(inout) :: ode
      !> Time [s].
      real(wp), intent(in) :: t
      !> State: (n).
      real(wp), intent(in), contiguous :: y(:)
      !> Its derivative: (n).
      real(wp), intent(in), contiguous :: ydot(:)
      !> There are none: (0).
      real(wp), intent(in), contiguous :: z(:)
      !> What is to vanish: (n).
      real(wp), intent(out), contiguous :: r(:)
      !> One of the `rhs_` constants.
      integer, intent(out) :: info

      self%evaluations = self%evaluations + 1
      call ode%rhs(t, y, r, info)
      r(:) = ydot - r
      if (info == rhs_ok .and. .not. all(ieee_is_finite(r))) info = rhs_retry
      associate (unused_z => z)
      end associate
   end subroutine residual

   !> What the right-hand side finds.
   subroutine find_integrand(self, ode, t, y, z)
      !> The equations.
      class(plain_equations_t), intent(inout) :: self
      !> The system.
      class(ode_system_t), intent(inout) :: ode
      !> Time [s].
      real(wp), intent(in) :: t
      !> State: (n).
      real(wp), intent(in), contiguous :: y(:)
      !> There are none: (0).
      real(wp), intent(in), contiguous :: z(:)
      integer :: info

      self%evaluations = self%evaluations + 1
      call ode%rhs(t, y, self%f, info)
      associate (unused_z => z)
      end associate
   end subroutine find_integrand

   !> df/dy.
   subroutine linearize(self, ode, t, h, y, ydot, z, info)
      !> The equations.
      class(plain_equations_t), intent(inout) :: self
      !> The system.
      class(ode_system_t), intent(inout) :: ode
      !> Time [s].
      real(wp), intent(in) :: t
      !> Step [s].
      real(wp), intent(in) :: h
      !> State: (n).
      real(wp), intent(in), contiguous :: y(:)
      !> Its derivative: (n).
      real(wp), intent(in), contiguous :: ydot(:)
      !> There are none: (0).
      real(wp), intent(in), contiguous :: z(:)
      !> One of the `rhs_` constants.
      integer, intent(out) :: info
      integer :: j
      real(wp) :: least, reach

      call ode%linearize(t, y, info)
      self%own = info == rhs_cannot
      if (.not. self%own) return
      self%evaluations = self%evaluations + self%n + 1
      call ode%rhs(t, y, self%f, info)
      if (info /= rhs_ok) return
      self%near(:) = y
      ! From rest at zero, the size of the state is that of where it goes.
      least = max(1.0e-3_wp*max(maxval(abs(y)), abs(h)*maxval(abs(self%f))), tiny(1.0_wp)/difference)
      do j = 1, self%n
         reach = difference*max(abs(y(j)), abs(h*ydot(j)), least)
         self%near(j) = y(j) + reach
         call ode%rhs(t, self%near, self%f_near, info)
         if (info /= rhs_ok) return
         self%jacobian(:, j) = (self%f_near - self%f)/(self%near(j) - y(j))
         self%near(j) = y(j)
      end do
      if (.not. all(ieee_is_finite(self%jacobian))) info = rhs_retry
      associate (unused_z => z)
      end associate
   end subroutine linearize

   !> shift*1 - df/dy.
   subroutine factorize(self, ode, slot, shift, info)
      !> The equations, linearized.
      class(plain_equations_t), intent(inout) :: self
      !> The system.
      class(ode_system_t), intent(inout) :: ode
      !> 1 for a shift without an imaginary part, 2 for one with.
      integer, intent(in) :: slot
      !> What d/dt is replaced by [1/s].
      complex(wp), intent(in) :: shift
      !> `rhs_ok`, or `rhs_retry` for a singular matrix.
      integer, intent(out) :: info
      integer :: i

      if (.not. self%own) then
         call ode%factorize(slot, shift, info)
         return
      end if
      if (slot == 1) then
         self%real_lu(:, :) = -self%jacobian
         do i = 1, self%n
            self%real_lu(i, i) = real(shift, wp) + self%real_lu(i, i)
         end do
         call dgetrf(self%n, self%n, self%real_lu, self%n, self%real_pivot, info)
      else
         self%complex_lu(:, :) = -self%jacobian
         do i = 1, self%n
            self%complex_lu(i, i) = shift + self%complex_lu(i, i)
         end do
         call zgetrf(self%n, self%n, self%complex_lu, self%n, self%complex_pivot, info)
      end if
      info = merge(rhs_ok, rhs_retry, info == 0)
   end subroutine factorize

   !> Newton's correction.
   subroutine solve(self, ode, slot, r)
      !> The equations, factorized.
      class(plain_equations_t), intent(inout) :: self
      !> The system.
      class(ode_system_t), intent(inout) :: ode
      !> Which factors.
      integer, intent(in) :: slot
      !> Residual, replaced by the correction: (n).
      complex(wp), intent(inout), contiguous :: r(:)
      integer :: info

      r(:) = -r
      if (.not. self%own) then
         call ode%solve(slot, r)
      else if (slot == 1) then
         self%real_r(:) = real(r, wp)
         call dgetrs('N', self%n, 1, self%real_lu, self%n, self%real_pivot, self%real_r, self%n, info)
         r(:) = self%real_r
      else
         call zgetrs('N', self%n, 1, self%complex_lu, self%n, self%complex_pivot, r, self%n, info)
      end if
   end subroutine solve

   !> q itself.
   subroutine multiply(self, q, r)
      !> The equations.
      class(plain_equations_t), intent(in) :: self
      !> A derivative of the state: (n).
      real(wp), intent(in), contiguous :: q(:)
      !> The same: (n).
      real(wp), intent(out), contiguous :: r(:)

      r(:) = q
      associate (unused_equations => self)
      end associate
   end subroutine multiply

   !> That of ydot - f(t, y), with f as large as ydot and what round-off of y changes in it, where the Jacobian is at hand.
   subroutine round_off(self, y, ydot, z, r)
      !> The equations, linearized.
      class(plain_equations_t), intent(inout) :: self
      !> State: (n).
      real(wp), intent(in), contiguous :: y(:)
      !> Its derivative: (n).
      real(wp), intent(in), contiguous :: ydot(:)
      !> There are none: (0).
      real(wp), intent(in), contiguous :: z(:)
      !> Its size: (n).
      real(wp), intent(out), contiguous :: r(:)
      integer :: i, j

      do i = 1, self%n
         r(i) = epsilon(1.0_wp)*abs(ydot(i))
      end do
      if (self%own) then
         do j = 1, self%n
            do i = 1, self%n
               r(i) = r(i) + epsilon(1.0_wp)*abs(self%jacobian(i, j)*y(j))
            end do
         end do
      end if
      associate (unused_z => z)
      end associate
   end subroutine round_off

end module taut_ode_stage_equations
