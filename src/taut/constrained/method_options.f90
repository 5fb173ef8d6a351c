!> Which method enforces the constraints, by name, and its options.
module taut_constrained_method_options
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   use taut_linalg_normal_solver_choose, only: solver_names
   implicit none (type, external)
   private
   public :: method_t, method_names

   !> All methods.
   character(len=21), parameter :: method_names(*) = [character(len=21) :: 'baseline', 'present', 'baumgarte', &
                                                      'braun-goldfarb', 'yu-chen', 'coordinate-projection', 'penalty', &
                                                      'unconstrained', 'minimal-coordinates', 'bayo-penalty', &
                                                       'augmented-lagrangian', 'udwadia-kalaba', 'dummy-derivatives', &
                                                       'gear-gupta-leimkuhler', 'fuhrer-leimkuhler', 'embedded-projection']

   !> A method and its options. Texts may be padded with blanks.
   type :: method_t
      !> `baseline`: Eq. (8). `present`: Eqs (11)-(17), Sect. 3.5. `baumgarte`: Eq. (8) with
      !! A vdot = b'' - 2 alpha (A v - b') - beta^2 phi. `braun-goldfarb`: A xdot = b' - phi/dt and
      !! A vdot = b'' - (A v - b')/dt. `yu-chen`: Eq. (8), position and velocity corrected when a violation exceeds
      !! `correction_tolerance`. `coordinate-projection`: Eq. (8), both levels projected after each step (Eich).
      !! `penalty`: no multipliers, f - A^T (stiffness phi + damping (A v - b')).
      !! `unconstrained`: M vdot = f, from the initial state as given; the constraints are evaluated and not enforced, and
      !! the system is told so (its procedure `enforce`). `minimal-coordinates`: Eq. (3), in velocities that are `independent`.
      !! `bayo-penalty`, `augmented-lagrangian`: M vdot + A^T penalty_factor (A vdot - b'' + 2 omega mu (A v - b') + omega^2
      !! phi) = f, the second with multipliers corrected until the accelerations meet it. `udwadia-kalaba`: vdot = a + M^-1/2 (A
      !! M^-1/2)^+ (b'' - A a). `dummy-derivatives`: phi = 0, A v = b' and A vdot = b'' solved for dependent variables (Mattsson
      !! and Soderlind). `gear-gupta-leimkuhler`, `fuhrer-leimkuhler`: stabilized index 2, the second with A vdot = b'' too,
      !! with multipliers that are found from where a stage leads. `embedded-projection`: velocities without the impulse of the
      !! reactions are integrated, and the impulse meets A v = b'.
      character(len=32) :: name = 'present'
      !> W of Eqs (11a), (16), (17): `identity`, `mass` (W = M) or `given` (the system's own procedure `weight`).
      character(len=16) :: weight = 'identity'
      !> `present`, `minimal-coordinates`: `newton` projects x before each right-hand side is evaluated (Sect. 3.5 a); `none`
      !! evaluates A at the stage's own x.
      character(len=16) :: stage_projection = 'newton'
      !> `present`: what of the state is replaced at the end of each accepted step: `none`, `position` or
      !! `position-velocity`. `minimal-coordinates`: with `none`, positions are the integrals of the velocities and drift.
      character(len=24) :: state_projection = 'position-velocity'
      !> `present`: constraints corrected in `acceleration` form, Sect. 3.5 (h), or in `force` form, (g) and Eq. (19b).
      character(len=16) :: form = 'acceleration'
      !> `present` with an explicit integrator: whether a system may leave out what follows from the rest of it by itself, such as
      !! the center of what turns about a fixed point, or a body that is welded to another one. The motion and all that is told
      !! of it are the same; what is left is projected by its own mass, whatever `weight` says.
      logical :: reduce = .true.
      !> `minimal-coordinates`: velocities along an orthonormal basis of the `null-space` of A, chosen anew where it no longer
      !! fits; or single ones by `partitioning`, switched where their pivots ask for others; or a basis that stays `constant`.
      character(len=16) :: independent = 'null-space'
      !> What is done with S = A M^-1 A^T. `auto`: of a system that states the pattern of A, `banded` or `sparse` where that
      !! pays; else Cholesky with pivoting, `pivoted-cholesky`. `dgelsd`: singular values. `banded`, `sparse`: L D L^T in an
      !! ordering with a small bandwidth or with little fill. `factor`: DGELSD on A L^-T with M = L L^T, which does not square the
      !! condition number.
      character(len=16) :: solver = 'auto'
      !> What a row of A must have that others do not have, relative to their size, in order not to be redundant; 0 for 3e-7.
      !! `dgelsd`: if not 0, the relative size below which singular values of S count as zero, and nothing else decides.
      real(wp) :: rcond = 0.0_wp
      !> Gains of `baumgarte` [1/s].
      real(wp) :: alpha = 2.0_wp, beta = 2.0_wp
      !> Time constant of `braun-goldfarb` [s].
      real(wp) :: dt = 0.1_wp
      !> Violation above which `yu-chen` corrects, in the unit of phi and of phidot.
      real(wp) :: correction_tolerance = 1.0e-6_wp
      !> Stiffness and damping of `penalty` [force/unit of phi, force/unit of phidot].
      real(wp) :: stiffness = 0.0_wp, damping = 0.0_wp
      !> alpha of `bayo-penalty` and `augmented-lagrangian`, in the unit of a mass where phi is a length; their frequency [1/s];
      !! their damping ratio [-].
      real(wp) :: penalty_factor = 1.0e7_wp, omega = 10.0_wp, mu = 1.0_wp
      !> Largest entry of phi that counts as none, in the unit of phi, of a system of the size 1 or more: see
      !! `taut_constrained_yardstick` for others.
      real(wp) :: projection_tolerance = 1.0e-12_wp
      !> Largest number of iterations of Eq. (17), and of `augmented-lagrangian`.
      integer :: max_iterations = 25
      !> Whether constraints that cannot all be met are carried on with, at the point where their violation is least.
      logical :: accept_inconsistent = .false.
   contains
      procedure :: check
      procedure :: place
   end type method_t

contains

   !> Whether names and numbers are valid, but for the options that only one method has: see `check_method`.
   subroutine check(self, error)
      !> The method.
      class(method_t), intent(in) :: self
      !> What is not.
      type(error_t), allocatable, intent(inout) :: error
      character(:), allocatable :: here

      here = self%place()
      if (.not. any(method_names == self%name)) then
         call raise(error, here, 'there is no method "'//trim(self%name)//'"', 'use one of '//listed(method_names))
         return
      end if
      call one_of('weight', self%weight, [character(len=24) :: 'identity', 'mass', 'given'])
      call one_of('stage_projection', self%stage_projection, [character(len=24) :: 'newton', 'none'])
      call one_of('state_projection', self%state_projection, [character(len=24) :: 'none', 'position', 'position-velocity'])
      call one_of('form', self%form, [character(len=24) :: 'acceleration', 'force'])
      call one_of('independent', self%independent, [character(len=24) :: 'null-space', 'partitioning', 'constant'])
      call one_of('solver', self%solver, solver_names)
      if (.not. (self%rcond >= 0.0_wp .and. self%rcond < 1.0_wp)) &
         call raise(error, here, 'rcond = '//to_text(self%rcond)//' is not between 0 and 1', 'give 0 for the default')
      if (.not. self%projection_tolerance > 0.0_wp) &
         call raise(error, here, 'projection_tolerance = '//to_text(self%projection_tolerance)//' is not positive', &
                    'give a tolerance such as 1e-12')
      if (self%max_iterations < 1) &
         call raise(error, here, 'max_iterations = '//to_text(self%max_iterations)//' is not positive', 'give 1 or more')

   contains

      subroutine one_of(option, value, choices)
         character(*), intent(in) :: option, value, choices(:)

         if (.not. any(choices == value)) &
            call raise(error, here, option//' = "'//trim(value)//'" is unknown', 'use one of '//listed(choices))
      end subroutine one_of

   end subroutine check

   !> What errors say of where they are.
   pure function place(self) result(text)
      !> The method.
      class(method_t), intent(in) :: self
      !> Such as: method "present".
      character(len=len_trim(self%name) + 9) :: text

      text = 'method "'//trim(self%name)//'"'
   end function place

   !> Names in one line.
   pure function listed(names) result(text)
      character(*), intent(in) :: names(:)
      character(len=sum(len_trim(names)) + 4*size(names) - 2) :: text
      integer :: i, last

      text = '"'//trim(names(1))//'"'
      do i = 2, size(names)
         last = sum(len_trim(names(:i - 1))) + 4*(i - 1) - 2
         text(last + 1:) = ', "'//trim(names(i))//'"'
      end do
   end function listed

end module taut_constrained_method_options
