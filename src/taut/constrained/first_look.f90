!> A cheap look at a system before it is simulated: derivatives along one direction each, whatever its size. What looks wrong is
!! left to `verify`, which has the last word and the names.
module taut_constrained_first_look
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use taut_kinds, only: wp
   use taut_error, only: error_t, raise, to_text
   use taut_constrained_method_options, only: method_t
   use taut_constrained_jacobian, only: evaluate_jacobian, lay_out_jacobian
   use taut_constrained_start, only: consistent_start, start_report_t
   use taut_constrained_system, only: mechanical_system_t, state_t
   use taut_constrained_verify, only: finding_t, shaken, verify
   use taut_linalg_arbitrary, only: arbitrary
   use taut_linalg_block_diagonal, only: block_diagonal_t
   use taut_linalg_csr, only: csr_t
   use taut_linalg_null_space, only: null_space
   implicit none (type, external)
   private
   public :: first_look, look_at_dependence

   !> Steps of the central differences, for sizes that a system may be of.
   real(wp), parameter :: steps(3) = [6.0e-6_wp, 6.0e-8_wp, 6.0e-4_wp]
   !> Difference that looks wrong, relative to the largest of what is compared.
   real(wp), parameter :: suspicious = 1.0e-6_wp
   !> Part of b'' that no acceleration can make, above which velocities are none that the constraints allow.
   real(wp), parameter :: contradiction = 1.0e-3_wp
   !> What is compared.
   integer, parameter :: of_phi_along_u = 1, of_phi_in_time = 2, of_rate = 3
   !> Entries of A up to which `verify` may compare them one by one.
   integer, parameter :: most_entries = 100000

contains

   !> Looks at a system near its start.
   subroutine first_look(model, at, error)
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Its start, on the constraints.
      type(state_t), intent(in) :: at
      !> What is wrong, if it is certain.
      type(error_t), allocatable, intent(inout) :: error
      type(finding_t), allocatable :: findings(:)
      type(error_t), allocatable :: no_start
      type(start_report_t) :: report
      type(state_t) :: near
      character(:), allocatable :: name
      integer :: row

      ! Time stands still at the start, where drives may have a kink; near it everything moves.
      call look(model, at, .false., row)
      near = shaken(model, at, 1)
      call consistent_start(model, method_t(), near, report, no_start)
      if (allocated(no_start)) then
         if (row == 0) return
         deallocate (no_start)
         near = at
      else if (row == 0) then
         call look(model, near, .true., row)
         if (row == 0 .and. model%constant_mass) call look_at_mass(model, at, near, row)
      end if
      if (row == 0) return
      if (real(model%c, wp)*real(model%n, wp) > real(most_entries, wp)) then
         call model%row_name(row, name)
         call raise(error, 'first look', 'the derivatives of '//name//' look wrong', &
                    'try verify on a smaller system of its kind, or go on with look = .false.')
         return
      end if
      call verify(model, near, findings, no_start)
      if (allocated(no_start) .or. .not. allocated(findings)) return
      if (size(findings) > 0) &
         call raise(error, 'first look', findings(1)%message, 'mend it: verify lists all; look = .false. goes on without')
   end subroutine first_look

   !> Looks at a system some of whose rows depend on others at its start: at rows that no velocity changes, and at velocities that
   !! the constraints allow to first order and not to second, as where two curves touch.
   subroutine look_at_dependence(model, at, error)
      !> The system.
      class(mechanical_system_t), intent(in) :: model
      !> Its start, on the constraints.
      type(state_t), intent(in) :: at
      !> What is wrong, if it is certain.
      type(error_t), allocatable, intent(inout) :: error
      real(wp) :: a(model%c, model%n), b(model%c), left(model%c), phi(model%n_phi), moved(model%n_phi)
      real(wp), allocatable :: a_plus(:, :), z(:, :)
      type(state_t) :: near
      character(:), allocatable :: name
      integer :: i, info, rank

      call model%jacobian(at, a)
      call model%constraint(at, phi)
      near = at
      near%x = [(at%x(i) + steps(1)*arbitrary(i)*max(1.0_wp, maxval(abs(at%x))), i=1, model%n_x)]
      call model%normalize(near%x)
      call model%constraint(near, moved)
      do i = 1, model%n_phi
         if (maxval(abs(a(i, :))) > 0.0_wp .or. .not. abs(moved(i) - phi(i)) > suspicious*steps(1)) cycle
         call model%row_name(i, name)
         call raise(error, 'first look', 'no velocity changes '//name//': its row of A is zero, though its '// &
                    'phi depends on the coordinates', 'leave it out; what brings coordinates back to length one is `normalize`')
         return
      end do

      call null_space(a, z, a_plus, rank, info)
      if (info /= 0) return
      call model%acceleration_rhs(at, b)
      left = abs(b - matmul(a, matmul(a_plus, b)))
      i = maxloc(left, 1)
      if (.not. left(i) > contradiction*maxval(abs(b))) return
      call model%row_name(i, name)
      call raise(error, 'first look', 'the velocities of the start meet the constraints to first order only: '// &
                    name//' cannot be kept, its second derivative is off by '//to_text(left(i)), &
                    'start with velocities along which all constraints can be kept, or at rest; look = .false. goes on')
   end subroutine look_at_dependence

   !> A row whose derivatives look wrong, or 0.
   subroutine look(model, at, moving, row)
      class(mechanical_system_t), intent(in) :: model
      type(state_t), intent(in) :: at
      logical, intent(in) :: moving
      integer, intent(out) :: row
      type(csr_t) :: a
      type(state_t) :: near
      real(wp), allocatable :: b(:), g(:), minus(:), plus(:), slope(:), u(:), v(:), w(:)
      integer :: i

      row = 0
      if (model%c == 0) return
      call lay_out_jacobian(model, a)
      allocate (b(model%c), g(model%n_w), minus(model%c), plus(model%c), slope(model%c))
      u = [(arbitrary(i), i=1, model%n)]
      call evaluate_jacobian(model, at, a)
      call a%multiply(u, slope)
      near = at
      v = at%v
      w = at%w
      call compare(of_phi_along_u, slope(:model%n_phi), row)
      if (row > 0 .or. .not. moving) return
      call model%w_rate(at, g)
      call model%velocity_rhs(at, b)
      slope = -b
      call compare(of_phi_in_time, slope(:model%n_phi), row)
      if (row > 0) return
      call model%acceleration_rhs(at, b)
      slope = -b
      call compare(of_rate, slope, row)

   contains

      !> phi along a direction, phi in time, or A v - b' along the motion, a step from here.
      subroutine step_aside(what, h, value)
         integer, intent(in) :: what
         real(wp), intent(in) :: h
         real(wp), intent(out) :: value(:)

         near%x = at%x
         if (what == of_phi_along_u) then
            call model%displace(h*u, near%x)
         else
            near%t = at%t + h
            near%w = w + h*g
         end if
         if (what == of_rate) then
            call model%displace(h*v, near%x)
            call evaluate_jacobian(model, near, a)
            call model%velocity_rhs(near, b)
            call a%multiply(v, value, b)
         else
            call model%constraint(near, value)
         end if
      end subroutine step_aside

      !> The first row that agrees with none of the differences, or 0.
      subroutine compare(what, given, row)
         integer, intent(in) :: what
         real(wp), intent(in) :: given(:)
         integer, intent(out) :: row
         logical :: agrees(size(given))
         real(wp) :: difference(size(given)), h, scale
         integer :: i, k

         agrees = .false.
         scale = max(maxval(abs(given)), maxval(abs(v)), maxval(abs(at%x)), tiny(1.0_wp))
         do k = 1, size(steps)
            do i = 1, 2
               h = steps(k)
               if (i == 2) h = h*max(maxval(abs(at%x)), tiny(1.0_wp))
               h = max(h, 1.0e3_wp*spacing(at%t))
               call step_aside(what, h, plus(:size(given)))
               call step_aside(what, -h, minus(:size(given)))
               difference = (plus(:size(given)) - minus(:size(given)))/(2.0_wp*h)
               agrees = agrees .or. .not. (ieee_is_finite(difference) .and. ieee_is_finite(given)) .or. &
                        abs(difference - given) <= suspicious*scale
               if (all(agrees)) exit
            end do
         end do
         row = findloc(agrees, .false., 1)
      end subroutine compare

   end subroutine look

   !> A row of M that changes, or 0.
   subroutine look_at_mass(model, here, near, row)
      class(mechanical_system_t), intent(in) :: model
      type(state_t), intent(in) :: here, near
      integer, intent(out) :: row
      type(block_diagonal_t) :: m
      real(wp), allocatable :: before(:)

      call m%init(model%mass_blocks)
      call model%mass(here, m)
      before = m%values
      call model%mass(near, m)
      row = 0
      if (any(abs(m%values - before) > suspicious*maxval(abs(before)))) row = 1
   end subroutine look_at_mass

end module taut_constrained_first_look
