!> The penalty formulation of Bayo, Garcia de Jalon and Serna: M vdot + A^T alpha (phiddot + 2 omega mu phidot + omega^2 phi) =
!! f, with phiddot = A vdot - b'': mass, damping and stiffness alpha, 2 alpha omega mu and alpha omega^2 on every constraint.
!!
!! With lambda = alpha (A vdot - b), b = b'' - 2 omega mu phidot - omega^2 phi, this is (S + 1/alpha) lambda = A a - b, S = A
!! M^-1 A^T: a positive definite matrix at any rank, so that redundant rows and singular positions need no decision; lambda is
!! in the range of S, of least norm where rows are redundant. As alpha grows the motion tends to that of Baumgarte's method with
!! the gains alpha_b = omega mu and beta_b = omega; at rest, a constraint gives way by lambda/(alpha omega^2).
!!
!! Source: E. Bayo, J. Garcia de Jalon, M.A. Serna, A modified Lagrangian formulation for the dynamic analysis of constrained
!! mechanical systems, Comput. Methods Appl. Mech. Eng. 71 (1988) 183-195. The paper's reference [24] for the method is to Bayo
!! et al.
module taut_constrained_method_bayo_penalty
   use taut_kinds, only: wp
   use taut_constrained_method, only: constrained_ode_t
   use taut_constrained_method_options, only: method_t
   use taut_error, only: error_t, raise, to_text
   use taut_linalg_lapack, only: dpotrf, dpotrs
   use taut_ode_system, only: rhs_ok, rhs_retry
   implicit none (type, external)
   private
   public :: bayo_penalty_t

   !> The iteration goes on while it leaves less than this part of the violation.
   real(wp), parameter :: still_falls = 0.5_wp

   !> The method `bayo-penalty`.
   type, extends(constrained_ode_t) :: bayo_penalty_t
      !> S + 1/alpha, its factor: (c, c); one row, as a force and as an acceleration: (c), (n), (n); the violation that is left:
      !! (c).
      real(wp), allocatable, private :: s(:, :), pick(:), u(:), moved(:), left(:)
   contains
      procedure :: check_options
      procedure :: set_up
      procedure :: rhs
      procedure :: most_iterations
   end type bayo_penalty_t

contains

   !> Whether alpha, omega and mu make sense.
   subroutine check_options(self, options, error)
      !> The formulation, not yet set up.
      class(bayo_penalty_t), intent(in) :: self
      !> The options.
      type(method_t), intent(in) :: options
      !> One that does not.
      type(error_t), allocatable, intent(inout) :: error

      if (.not. options%penalty_factor > 0.0_wp) &
         call raise(error, options%place(), 'penalty_factor = '//to_text(options%penalty_factor)//' is not positive', &
                    'give the alpha of the formulation, such as 1e7 times a mass')
      if (.not. (options%omega >= 0.0_wp .and. options%mu >= 0.0_wp)) &
         call raise(error, options%place(), 'omega = '//to_text(options%omega)//', mu = '//to_text(options%mu)// &
                    ': one of them is negative', 'give a frequency such as 10 and a damping ratio such as 1')
      associate (unused_formulation => self)
      end associate
   end subroutine check_options

   !> Makes room.
   subroutine set_up(self, error)
      !> The formulation.
      class(bayo_penalty_t), intent(inout) :: self
      !> More constraints than full matrices are good for.
      type(error_t), allocatable, intent(inout) :: error

      self%carries_reactions = .false.
      call self%refuse_large(error)
      if (allocated(error)) return
      associate (c => self%model%c, n => self%model%n)
         allocate (self%s(c, c), self%pick(c), self%u(n), self%moved(n), self%left(c), source=0.0_wp)
      end associate
   end subroutine set_up

   !> How often the multipliers are corrected: once, the penalty itself.
   pure integer function most_iterations(self)
      !> The formulation.
      class(bayo_penalty_t), intent(in) :: self

      most_iterations = 1
      associate (unused_formulation => self)
      end associate
   end function most_iterations

   !> The derivative with the multipliers of the penalty, corrected until they meet the constraints or no more is gained.
   subroutine rhs(self, t, y, dydt, info)
      !> The formulation.
      class(bayo_penalty_t), intent(inout) :: self
      !> Time [s].
      real(wp), intent(in) :: t
      !> State {x; v; w}: (size).
      real(wp), intent(in), contiguous :: y(:)
      !> Its derivative: (size).
      real(wp), intent(out), contiguous :: dydt(:)
      !> One of the `rhs_` constants.
      integer, intent(out) :: info
      integer :: last_v, n_x

      n_x = self%model%n_x
      last_v = n_x + self%model%n
      associate (model => self%model, at => self%at, projector => self%projector, vdot => dydt(n_x + 1:last_v))
         call self%unpack(t, y, at)
         call model%normalize(at%x)
         call projector%linear%evaluate(model, at)
         call self%mass%renew(model, at, info)
         if (info /= rhs_ok) return
         call model%force(at, self%force)
         call self%mass%accelerate(projector, self%force, vdot)
         if (model%c > 0) then
            call model%acceleration_rhs(at, self%b_second)
            call self%find_violations()
            self%b_second(:) = self%b_second - 2.0_wp*self%options%omega*self%options%mu*self%phidot
            self%b_second(:model%n_phi) = self%b_second(:model%n_phi) - self%options%omega**2*self%phi
            call projector%linear%a%multiply(vdot, self%left, self%b_second)
            call find_multipliers(self, info)
            if (info /= rhs_ok) return
            call projector%linear%a%subtract_transposed(self%lambda, self%force)
            call self%mass%accelerate(projector, self%force, vdot)
         end if
         ! As of `penalty`: what the constraints do is work on A v = phidot + b'.
         if (self%has_integral) call self%find_power(self%phidot + projector%b_prime)
         call model%x_rate(at, at%v, dydt(:n_x))
         if (model%n_w > 0) call model%w_rate(at, dydt(last_v + 1:))
      end associate
   end subroutine rhs

   !> lambda with (S + 1/alpha) dlambda = the violation that is left, which then is dlambda/alpha.
   subroutine find_multipliers(self, info)
      class(bayo_penalty_t), intent(inout) :: self
      integer, intent(out) :: info
      integer :: c, i, iteration
      real(wp) :: before, largest, wanted

      c = self%model%c
      do i = 1, c
         self%pick(:) = 0.0_wp
         self%pick(i) = -1.0_wp
         self%u(:) = 0.0_wp
         call self%projector%linear%a%subtract_transposed(self%pick, self%u)
         call self%mass%accelerate(self%projector, self%u, self%moved)
         call self%projector%linear%a%multiply(self%moved, self%s(:, i))
         self%s(i, i) = self%s(i, i) + 1.0_wp/self%options%penalty_factor
      end do
      info = rhs_retry
      if (.not. all(abs(self%s) <= huge(1.0_wp))) return
      call dpotrf('L', c, self%s, c, i)
      if (i /= 0) return
      info = rhs_ok
      self%lambda(:) = 0.0_wp
      largest = maxval(abs(self%left))
      wanted = self%options%projection_tolerance*largest
      do iteration = 1, self%most_iterations()
         self%projector%newton%iterations = self%projector%newton%iterations + 1
         call dpotrs('L', c, 1, self%s, c, self%left, c, i)
         self%lambda(:) = self%lambda + self%left
         self%left(:) = self%left/self%options%penalty_factor
         before = largest
         largest = maxval(abs(self%left))
         ! What no multipliers reach, of rows that contradict each other beside the constraints, stays.
         if (largest <= wanted .or. largest > still_falls*before) exit
      end do
   end subroutine find_multipliers

end module taut_constrained_method_bayo_penalty
